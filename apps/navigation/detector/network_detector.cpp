#include "detector/network_detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include <opencv2/core/utils/logger.hpp>

#include "detector/darknet_file.h"
#include "program/fingerprint.h"
#include "program/text_file.h"

namespace ctn::navigation {
namespace {

constexpr int kBeforeClasses = 5;  // of an output's row: x, y, width, height, whether there is anything

// OpenCV prints what goes wrong when it makes a network; here that becomes an error, which the caller shows.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
  }
  ~Silence() {
    cv::redirectError(nullptr);
    cv::utils::logging::setLogLevel(before_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

Result<std::string> contents(const std::string& path, const char* what) {
  std::error_code unreadable;
  std::optional<std::string> text;
  if (std::filesystem::is_regular_file(path, unreadable)) text = program::text_of_file(path);
  if (text) return std::move(*text);
  return Error::caller(fmt::format("cannot read the network's {} {}", what, path),
                       "is the path right? A network is two files: --model FILE.cfg FILE.weights");
}

std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  std::string line;
  for (const char letter : text + '\n') {
    if (letter == '\n') {
      if (!line.empty()) lines.push_back(std::move(line));
      line.clear();
    } else if (letter != '\r') {
      line += letter;
    }
  }
  return lines;
}

// The numbers after the header of a file of weights: version (three integers), and how many pictures it was trained
// with, an integer of four bytes or, in newer versions, of eight. 0 if there is not even a header.
std::size_t numbers_in(const std::string& weights) {
  std::array<std::int32_t, 3> version{};
  if (weights.size() < sizeof(version) + sizeof(std::int32_t)) return 0;
  std::memcpy(version.data(), weights.data(), sizeof(version));
  const bool newer = version[0] * 10 + version[1] >= 2;
  const std::size_t header = sizeof(version) + (newer ? sizeof(std::int64_t) : sizeof(std::int32_t));
  return weights.size() < header ? 0 : (weights.size() - header) / sizeof(float);
}

struct NetworkSize {
  std::size_t numbers = 0;  // in its file of weights
  PictureWork work;         // of one run
};

NetworkSize size_of(const cv::dnn::Net& network, cv::Size input) {
  std::vector<int> layers;
  std::vector<std::vector<cv::dnn::MatShape>> inputs;
  std::vector<std::vector<cv::dnn::MatShape>> outputs;
  network.getLayersShapes(cv::dnn::MatShape{1, 3, input.height, input.width}, layers, inputs, outputs);
  NetworkSize size;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const cv::Ptr<cv::dnn::Layer> layer = network.getLayer(layers[i]);
    const bool convolution = layer->type == "Convolution";
    if (!convolution && layer->type != "BatchNorm" && layer->type != "InnerProduct") continue;
    for (const cv::Mat& numbers : layer->blobs) size.numbers += numbers.total();
    if (!convolution) continue;
    const cv::dnn::MatShape& shape = outputs[i].front();  // 1, channels, height, width
    const auto places = static_cast<std::uint64_t>(shape[2]) * static_cast<std::uint64_t>(shape[3]);
    size.work.multiply_adds += layer->blobs.front().total() * places;
    size.work.emitted += static_cast<std::uint64_t>(shape[1]) * places;
  }
  return size;
}

Error not_together(const NetworkFiles& files, std::string what) {
  return Error::caller(std::move(what), fmt::format("{} and {} must be of the same network, complete, and all of its "
                                                    "layers known to OpenCV {}",
                                                    files.description, files.weights, CV_VERSION));
}

Result<std::vector<std::string>> names_for(const NetworkFiles& files, int classes) {
  if (!files.names) return std::vector<std::string>{};
  const auto text = contents(*files.names, "names of classes");
  if (!text) return text.error();
  std::vector<std::string> names = lines_in(*text);
  if (names.size() != static_cast<std::size_t>(classes)) {
    return Error::caller(
        fmt::format("{} has {} names, but {} knows {} classes", *files.names, names.size(), files.description, classes),
        "write one name a line, in the order that the network was trained with");
  }
  return names;
}

// Of the boxes of each class that overlap the surest.
std::vector<Detection> without_overlaps(const std::map<int, std::vector<Detection>>& by_class) {
  std::vector<Detection> kept;
  for (const auto& [label, things] : by_class) {
    std::vector<cv::Rect2d> boxes;
    std::vector<float> scores;
    std::vector<int> chosen;
    for (const Detection& thing : things) {
      boxes.push_back(thing.box);
      scores.push_back(static_cast<float>(thing.confidence));
    }
    cv::dnn::NMSBoxes(boxes, scores, static_cast<float>(NetworkDetector::kConfidenceMin),
                      static_cast<float>(NetworkDetector::kOverlapMax), chosen);
    for (const int i : chosen) kept.push_back(things[static_cast<std::size_t>(i)]);
  }
  return kept;
}

}  // namespace

Result<std::unique_ptr<NetworkDetector>> NetworkDetector::open(const NetworkFiles& files) {
  const auto description = contents(files.description, "description");
  if (!description) return description.error();
  const auto weights = contents(files.weights, "weights");
  if (!weights) return weights.error();
  const auto file = read_darknet(*description, files.description);
  if (!file) return file.error();
  auto names = names_for(files, file->classes);
  if (!names) return names.error();

  cv::setNumThreads(1);
  const Silence silence;
  std::unique_ptr<NetworkDetector> detector(new NetworkDetector());
  detector->input_ = {file->width, file->height};
  detector->names_ = std::move(names).value();
  try {
    cv::dnn::Net& network = detector->network_;
    network = cv::dnn::readNetFromDarknet(description->data(), description->size(), weights->data(), weights->size());
    network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    const NetworkSize size = size_of(network, detector->input_);
    if (size.numbers != numbers_in(*weights)) {
      return not_together(files, fmt::format("{} has {} numbers, but the network of {} takes {}", files.weights,
                                             numbers_in(*weights), files.description, size.numbers));
    }
    detector->work_ = size.work;
    detector->output_names_ = network.getUnconnectedOutLayersNames();
    if (auto checked = detector->check_outputs(files.description, file->classes); !checked) return checked.error();
  } catch (const std::exception& failure) {  // cv::Exception, or out of memory
    return not_together(files, fmt::format("OpenCV cannot make a network of {} and {}: {}", files.description,
                                           files.weights, failure.what()));
  }
  program::Fingerprint fingerprint;
  fingerprint.add(*description);
  fingerprint.add(*weights);
  detector->identity_ = fmt::format("network {:016x} {} {}", fingerprint.value(), kConfidenceMin, kOverlapMax);
  return detector;
}

Status NetworkDetector::check_outputs(const std::string& description, int classes) {
  const std::array<int, 4> shape{1, 3, input_.height, input_.width};
  forward(cv::Mat(4, shape.data(), CV_32F, cv::Scalar(0.5)));
  for (const cv::Mat& output : outputs_) {
    if (output.dims == 2 && output.cols == kBeforeClasses + classes) continue;
    return Error::caller(fmt::format("the network of {} has an output that holds no detections", description),
                         "its last layers must be [yolo] or [region]");
  }
  return Done{};
}

void NetworkDetector::forward(const cv::Mat& input) {
  network_.setInput(input);
  network_.forward(outputs_, output_names_);
}

std::string NetworkDetector::name(int label) const {
  const auto at = static_cast<std::size_t>(label);
  return at < names_.size() ? names_[at] : fmt::format("class {}", label);
}

Detections NetworkDetector::run(const Prepared& picture) {
  assert(picture.input.dims == 4 && picture.input.size[2] == input_.height && picture.input.size[3] == input_.width);
  forward(picture.input);
  std::map<int, std::vector<Detection>> by_class;
  for (const cv::Mat& output : outputs_) {
    for (int row = 0; row < output.rows; ++row) {
      const std::span<const float> values(output.ptr<float>(row), static_cast<std::size_t>(output.cols));
      const auto scores = values.subspan(kBeforeClasses);  // already times that there is anything
      const auto best = std::ranges::max_element(scores);
      if (!std::isfinite(*best) || static_cast<double>(*best) < kConfidenceMin) continue;
      const double width = static_cast<double>(values[2]) * input_.width;
      const double height = static_cast<double>(values[3]) * input_.height;
      const cv::Rect2d in_input(static_cast<double>(values[0]) * input_.width - 0.5 * width,
                                static_cast<double>(values[1]) * input_.height - 0.5 * height, width, height);
      const cv::Rect2d box = picture.letterbox.to_picture(in_input);
      const auto label = static_cast<int>(best - scores.begin());
      if (box.area() > 0.0) by_class[label].push_back({label, static_cast<double>(*best), box});
    }
  }
  Detections found{without_overlaps(by_class), work_};
  sort_by_confidence(found.things);
  return found;
}

}  // namespace ctn::navigation
