#include "detector/known_detections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <fstream>
#include <utility>

#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

namespace ctn::navigation {
namespace {

using nlohmann::json;

json to_json(const std::vector<Detection>& things) {
  json list = json::array();
  for (const Detection& thing : things) {
    const cv::Rect2d& box = thing.box;
    list.push_back({thing.label, thing.confidence, box.x, box.y, box.width, box.height});
  }
  return list;
}

std::vector<Detection> from_json(const json& list) {
  std::vector<Detection> things;
  for (const json& thing : list) {
    things.push_back(
        {thing.at(0).get<int>(),
         thing.at(1).get<double>(),
         {thing.at(2).get<double>(), thing.at(3).get<double>(), thing.at(4).get<double>(), thing.at(5).get<double>()}});
  }
  return things;
}

}  // namespace

KnownDetections::KnownDetections(const Film& film, std::unique_ptr<Detector> detector,
                                 const PreprocessSettings& settings)
    : film_(film), detector_(std::move(detector)), preprocess_(detector_->form(), settings), frames_(film.frames()) {}

const std::vector<Detection>& KnownDetections::at(std::size_t frame) {
  assert(frame < frames_.size());
  auto& known = frames_[frame];
  if (!known) {
    const auto prepared = preprocess_.run(film_.picture(frame));
    assert(prepared.ok());  // the film has encoded it itself
    known = detector_->run(*prepared).things;
  }
  return *known;
}

std::size_t KnownDetections::known() const {
  return static_cast<std::size_t>(std::ranges::count_if(frames_, [](const auto& frame) { return frame.has_value(); }));
}

// What results depend on. OpenCV's routines differ from processor to processor in the last digits.
std::string KnownDetections::identity() const {
  return fmt::format("film {:016x} {}; {}; {}; OpenCV {} {}", film_.fingerprint(), film_.frames(),
                     preprocess_.identity(), detector_->identity(), CV_VERSION, cv::getCPUFeaturesLine());
}

void KnownDetections::load(const std::string& path) {
  std::ifstream file(path);
  if (!file) return;
  try {
    const json document = json::parse(file);
    if (document.at("of").get<std::string>() != identity()) return;
    auto frames = frames_;
    for (const auto& [number, things] : document.at("frames").items()) {
      frames.at(std::stoul(number)) = from_json(things);
    }
    frames_ = std::move(frames);
  } catch (const std::exception&) {
    return;  // damaged: what was in it is computed again
  }
}

Status KnownDetections::save(const std::string& path) const {
  json frames = json::object();
  for (std::size_t frame = 0; frame < frames_.size(); ++frame) {
    if (frames_[frame]) frames[std::to_string(frame)] = to_json(*frames_[frame]);
  }
  const std::string whole = json{{"of", identity()}, {"frames", std::move(frames)}}.dump() + '\n';
  const std::string unfinished = path + ".new";
  std::ofstream file(unfinished, std::ios::binary);
  file << whole;
  file.close();
  std::error_code failed;
  if (file) std::filesystem::rename(unfinished, path, failed);
  if (!file || failed) {
    std::filesystem::remove(unfinished, failed);
    return Error::environment("cannot write " + path, "is its folder there, may you write to it, is the disk full?");
  }
  return Done{};
}

}  // namespace ctn::navigation
