#include "drawing/picture_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "program/fingerprint.h"

namespace ctn::vr::drawing {
namespace {

constexpr std::uint64_t kVersion = 1;  // changes with what drawing makes of the same room
constexpr std::size_t kFingerprintBytes = sizeof(std::uint64_t);
constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20U;

std::uint64_t fingerprint_of(std::span<const unsigned char> bytes) {
  program::Fingerprint fingerprint;
  fingerprint.add(bytes);
  return fingerprint.value();
}

template <class Value>
void add_value(program::Fingerprint& fingerprint, Value value) {
  std::array<unsigned char, sizeof value> bytes{};
  std::memcpy(bytes.data(), &value, sizeof value);
  fingerprint.add(bytes);
}

// No two writers share it, in this process or another.
std::string another_name(const std::string& file) {
  static std::atomic<unsigned> number{0};
  return fmt::format("{}.{}.{}", file, ::getpid(), number.fetch_add(1));
}

}  // namespace

std::uint64_t key_of_pictures(std::uint64_t room, std::uint64_t trajectory, const CameraModel& camera) {
  program::Fingerprint fingerprint;
  for (const std::uint64_t part : {kVersion, room, trajectory}) add_value(fingerprint, part);
  add_value(fingerprint, camera.width);
  add_value(fingerprint, camera.height);
  const Eigen::Quaterniond& turned = camera.body_from_camera.orientation;
  const Eigen::Vector3d& placed = camera.body_from_camera.position;
  for (const double part : {camera.fx, camera.fy, camera.cx, camera.cy, camera.k1, camera.k2, camera.p1, camera.p2,
                            turned.w(), turned.x(), turned.y(), turned.z(), placed.x(), placed.y(), placed.z()}) {
    add_value(fingerprint, part);
  }
  return fingerprint.value();
}

Result<PictureCache> PictureCache::open(const std::string& folder, std::uint64_t key, const CameraModel& camera) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    return Error::caller(folder + " is no folder to keep pictures in", "give the name of a folder");
  }
  PictureCache cache;
  cache.folder_ = fmt::format("{}/{:016x}", folder, key);
  cache.width_ = camera.width;
  cache.height_ = camera.height;
  fs::create_directories(cache.folder_, error);
  if (error || !fs::is_directory(cache.folder_, error)) {
    return Error::environment("cannot make the folder " + cache.folder_ + " for pictures",
                              "may you write there? else keep them in another folder");
  }
  return cache;
}

std::string PictureCache::file_of(std::chrono::nanoseconds time) const {
  return fmt::format("{}/{}.png", folder_, time.count());
}

bool PictureCache::read(std::chrono::nanoseconds time, std::vector<std::uint8_t>& picture) const {
  const std::string file = file_of(time);
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error || size <= kFingerprintBytes || size > kMaxFileBytes) return false;
  std::ifstream in(file, std::ios::binary);
  std::vector<unsigned char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (bytes.size() <= kFingerprintBytes) return false;
  std::uint64_t written = 0;
  std::memcpy(&written, bytes.data() + bytes.size() - kFingerprintBytes, kFingerprintBytes);
  bytes.resize(bytes.size() - kFingerprintBytes);
  if (written != fingerprint_of(bytes)) return false;
  const cv::Mat decoded = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (decoded.type() != CV_8UC1 || decoded.cols != width_ || decoded.rows != height_ || !decoded.isContinuous()) {
    return false;
  }
  picture.assign(decoded.data, decoded.data + decoded.total());
  return true;
}

Status PictureCache::write(std::chrono::nanoseconds time, const std::vector<std::uint8_t>& picture) const {
  assert(picture.size() == static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const cv::Mat rows(height_, width_, CV_8UC1, const_cast<std::uint8_t*>(picture.data()));  // only read
  std::vector<unsigned char> bytes;
  cv::imencode(".png", rows, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1});
  const std::uint64_t fingerprint = fingerprint_of(bytes);
  const std::string file = file_of(time);
  const std::string unfinished = another_name(file);
  {
    std::ofstream out(unfinished, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.write(reinterpret_cast<const char*>(&fingerprint), kFingerprintBytes);
    out.close();
    std::error_code error;
    if (out) std::filesystem::rename(unfinished, file, error);
    if (out && !error) return Done{};
    std::filesystem::remove(unfinished, error);
  }
  return Error::environment("cannot write the picture " + file, "is the disk full, and may you write there?");
}

}  // namespace ctn::vr::drawing
