#include "footage.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <opencv2/videoio.hpp>

#include "lens.h"
#include "program/text_file.h"

namespace ctn::face_tracking {
namespace {

constexpr int kFaceSize = 150;        // side of the face as the cascade sees it, in raw pixels
constexpr double kPatchMargin = 1.7;  // side of the patch over that of the face
constexpr int kFilmStep = 4;          // every so many frames
constexpr int kFilmFaceMin = 150;     // pixels in the film; smaller ones would have to be enlarged
constexpr int kSeam = 60;             // columns over which neighbouring photographs are blended

const char* const kFilm = "Megamind.avi";
// Two of much texture, each twice: whichever way the camera looks, the detector has about as much to do.
const char* const kPhotos[] = {"leuvenA.jpg", "building.jpg", "leuvenA.jpg", "building.jpg"};

Error missing(const std::string& path, const std::string& package) {
  const std::string install = "sudo apt-get install --reinstall " + package;
  if (std::filesystem::exists(path + ".gz")) {
    return Error::environment(path + " is packed (.gz)", "unpack it: sudo gunzip -k " + path + ".gz");
  }
  if (std::filesystem::exists(path)) {
    return Error::environment("cannot decode " + path, "is it damaged? " + install);
  }
  return Error::environment("no " + path,
                            "it is part of the Debian package " + package + ": " + install +
                                "; where /etc/dpkg/dpkg.cfg.d/ excludes /usr/share/doc/*, let it through first");
}

cv::Mat soft_ellipse(int size) {
  cv::Mat alpha(size, size, CV_32FC1);
  const double centre = 0.5 * (size - 1);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double distance = std::hypot((x - centre) / (0.42 * size), (y - centre) / (0.5 * size));
      const double t = std::min(1.0, std::max(0.0, (1.0 - distance) / 0.25));
      alpha.at<float>(y, x) = static_cast<float>(t * t * (3.0 - 2.0 * t));
    }
  }
  cv::cvtColor(alpha, alpha, cv::COLOR_GRAY2BGR);
  return alpha;
}

int patch_side() { return static_cast<int>(std::lround(kPatchMargin * kFaceSize)); }

Face cut_out(const cv::Mat& frame, const cv::Rect& found, const cv::Mat& alpha) {
  const cv::Point2f centre(static_cast<float>(found.x) + 0.5F * static_cast<float>(found.width),
                           static_cast<float>(found.y) + 0.5F * static_cast<float>(found.height));
  const int side = static_cast<int>(std::lround(kPatchMargin * found.width));
  Face face;
  cv::getRectSubPix(frame, {side, side}, centre, face.pixels);
  cv::resize(face.pixels, face.pixels, alpha.size(), 0, 0, cv::INTER_AREA);
  // The film plays by candle light, the photographs were taken at noon.
  face.pixels.convertTo(face.pixels, -1, 1.5, 10.0);
  face.alpha = alpha;
  return face;
}

Result<std::vector<Face>> find_faces(const FootageFiles& files) {
  cv::setNumThreads(1);  // as nodes have it; with a pool, whose locks it does not see, the thread sanitizer finds races
  cv::CascadeClassifier cascade;
  if (!std::filesystem::exists(files.cascade()) || !cascade.load(files.cascade())) {
    return missing(files.cascade(), "opencv-data");
  }
  const std::string path = files.examples + "/" + kFilm;
  cv::VideoCapture film;
  if (!std::filesystem::exists(path) || !film.open(path)) return missing(path, "opencv-doc");

  const cv::Mat alpha = soft_ellipse(patch_side());
  std::vector<Face> faces;
  cv::Mat frame;
  cv::Mat grey;
  std::vector<cv::Rect> found;
  for (int number = 0; film.grab(); ++number) {
    if (number % kFilmStep != 0 || !film.retrieve(frame)) continue;
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    cascade.detectMultiScale(grey, found, 1.2, 5, 0, {kFilmFaceMin, kFilmFaceMin}, {260, 260});
    if (found.size() == 1) faces.push_back(cut_out(frame, found.front(), alpha));
  }
  if (faces.empty()) return missing(path, "opencv-doc");
  return faces;
}

Result<std::vector<Face>> read_faces(const std::string& path) {
  const cv::Mat row = cv::imread(path, cv::IMREAD_COLOR);
  const int side = patch_side();
  if (row.empty() || row.rows != side || row.cols % side != 0) {
    return Error::environment(path + " is no picture of the film's faces", "delete it, and it is made again");
  }
  const cv::Mat alpha = soft_ellipse(side);
  std::vector<Face> faces;
  for (int left = 0; left < row.cols; left += side) {
    faces.push_back({row.colRange(left, left + side).clone(), alpha});
  }
  return faces;
}

Status write_faces(const std::string& path, const std::vector<Face>& faces) {
  std::vector<cv::Mat> patches;
  for (const Face& face : faces) patches.push_back(face.pixels);
  cv::Mat row;
  cv::hconcat(patches, row);
  std::vector<unsigned char> png;
  cv::imencode(".png", row, png);
  const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
  if (!program::replace_file(path, bytes)) {
    return Error::environment("cannot write " + path, "check the folder's rights and the disk");
  }
  return Done{};
}

Result<std::vector<Face>> load_faces(const FootageFiles& files) {
  if (files.faces.empty()) return find_faces(files);
  if (std::filesystem::exists(files.faces)) return read_faces(files.faces);
  auto found = find_faces(files);
  if (!found) return found;
  if (Status written = write_faces(files.faces, *found); !written) return written.error();
  return found;
}

// The middle of the photograph, at the given size.
cv::Mat fitted(const cv::Mat& photo, cv::Size size) {
  const double scale =
      std::max(static_cast<double>(size.width) / photo.cols, static_cast<double>(size.height) / photo.rows);
  cv::Mat scaled;
  cv::resize(photo, scaled, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
  const cv::Rect middle((scaled.cols - size.width) / 2, (scaled.rows - size.height) / 2, size.width, size.height);
  return scaled(middle).clone();
}

// Blends `right` into the last kSeam columns of `left`, and cuts these columns off `right`.
void join(cv::Mat& left, cv::Mat& right) {
  for (int i = 0; i < kSeam; ++i) {
    const double weight = (i + 0.5) / kSeam;
    cv::Mat target = left.col(left.cols - kSeam + i);
    cv::addWeighted(target, 1.0 - weight, right.col(i), weight, 0.0, target);
  }
  right = right.colRange(kSeam, right.cols);
}

Result<cv::Mat> load_panorama(const FootageFiles& files) {
  const int ring = static_cast<int>(std::lround(2.0 * std::numbers::pi * kRawPixelsPerRadian));
  const int count = 2 * static_cast<int>(std::size(kPhotos));
  std::vector<cv::Mat> tiles;
  for (const char* name : kPhotos) {
    const std::string path = files.examples + "/" + name;
    const cv::Mat photo = cv::imread(path, cv::IMREAD_COLOR);
    if (photo.empty()) return missing(path, "opencv-doc");
    const int rest = ring * static_cast<int>(tiles.size() + 2) / count - ring * static_cast<int>(tiles.size()) / count;
    const cv::Mat first = fitted(photo, {rest / 2 + kSeam, kRawHeight});
    const cv::Mat second = fitted(photo, {rest - rest / 2 + kSeam, kRawHeight});
    tiles.push_back(first);
    cv::flip(second, tiles.emplace_back(), 1);
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) join(tiles[i], tiles[(i + 1) % tiles.size()]);
  cv::Mat panorama;
  cv::hconcat(tiles, panorama);
  return panorama;
}

}  // namespace

Result<Footage> load_footage(const FootageFiles& files) {
  auto faces = load_faces(files);
  if (!faces) return faces.error();
  auto panorama = load_panorama(files);
  if (!panorama) return panorama.error();
  return Footage{std::move(faces).value(), std::move(panorama).value()};
}

}  // namespace ctn::face_tracking
