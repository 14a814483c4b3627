#include "world/euroc.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <filesystem>
#include <optional>
#include <utility>

#include "program/text_file.h"

namespace ctn::vr::world {
namespace {

constexpr std::size_t kMaxProblems = 10;  // that are told of a file
const char* const kPage = "see docs/vr.md";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

// Lines of fields with commas between them; the first one is a time, later from line to line.
class Table {
 public:
  Table(std::string_view text, const std::string& file, std::size_t fields)
      : rest_(text), file_(file), fields_(fields) {}

  // The next line that is no comment and not empty; false at the end. A line with a mistake is left out.
  bool next() {
    while (!rest_.empty() && problems_.size() < kMaxProblems) {
      const std::size_t end = rest_.find('\n');
      const std::string_view line = trimmed(rest_.substr(0, end));
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_;
      if (line.empty() || line.front() == '#') continue;
      if (split(line)) return true;
    }
    return false;
  }

  std::int64_t time() const { return time_; }
  // Field `i`; the time is the 0th.
  std::string_view text(std::size_t i) const { return all_[i]; }
  // Reads all fields after the time as numbers.
  bool numbers(std::vector<double>& numbers) {
    numbers.clear();
    for (std::size_t i = 1; i < fields_; ++i) {
      double number = 0.0;
      if (!read_number(all_[i], number) || !std::isfinite(number)) {
        add(fmt::format("'{}' is not a number (field {})", all_[i], i + 1), "write one such as -0.25");
        return false;
      }
      numbers.push_back(number);
    }
    return true;
  }
  void add(std::string what, std::string hint) {
    problems_.push_back({{file_, line_, 0}, "", std::move(what), std::move(hint)});
  }

  template <class Row>
  Result<std::vector<Row>> finish(std::vector<Row> rows) {
    if (problems_.empty() && rows.empty()) {
      line_ = std::max(line_, 1);
      add("there is no data in the file", kPage);
    }
    if (!problems_.empty()) return Error(ErrorKind::kCaller, std::move(problems_));
    return rows;
  }

 private:
  bool split(std::string_view line) {
    all_.clear();
    for (;;) {
      const std::size_t comma = line.find(',');
      all_.push_back(trimmed(line.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
    if (all_.size() != fields_) {
      add(fmt::format("{} fields in place of {}", all_.size(), fields_), kPage);
      return false;
    }
    std::int64_t time = 0;
    if (!read_number(all_[0], time) || time < 0) {
      add(fmt::format("'{}' is not a time", all_[0]), "write nanoseconds, as a whole number");
      return false;
    }
    if (any_ && time <= time_) {
      add(fmt::format("{} is not after the time of the line before, {}", time, time_), "put lines in order of time");
      return false;
    }
    any_ = true;
    time_ = time;
    return true;
  }

  std::string_view rest_;
  const std::string& file_;
  std::size_t fields_;
  int line_ = 0;
  bool any_ = false;
  std::int64_t time_ = 0;
  std::vector<std::string_view> all_;
  std::vector<Problem> problems_;
};

Eigen::Vector3d vector_of(const std::vector<double>& numbers, std::size_t from) {
  return {numbers[from], numbers[from + 1], numbers[from + 2]};
}

double seconds(std::int64_t nanoseconds) { return static_cast<double>(nanoseconds) / 1e9; }

Result<std::string> contents_of(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return Error::caller("no file " + path, std::string("give the folder of a data set like EuRoC's; ") + kPage);
  }
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size > kMaxEurocBytes) {
    return Error::caller(fmt::format("{} is larger than {} MiB", path, kMaxEurocBytes >> 20U), "cut it into parts");
  }
  std::optional<std::string> text;
  if (!error) text = program::text_of_file(path);
  if (!text) return Error::environment("cannot read " + path, "is it readable, and is the disk well?");
  return std::move(*text);
}

template <class Rows, class Parse>
Status read(const std::string& path, Parse parse, Rows& rows, std::vector<Problem>& problems) {
  const Result<std::string> text = contents_of(path);
  if (!text && text.error().kind() == ErrorKind::kEnvironment) return text.error();
  auto parsed = text ? parse(*text, path) : decltype(parse("", path))(text.error());
  if (parsed) {
    rows = std::move(*parsed);
  } else {
    const std::vector<Problem>& found = parsed.error().problems();
    problems.insert(problems.end(), found.begin(), found.end());
  }
  return Done{};
}

class CameraReader {
 public:
  explicit CameraReader(std::string file) : file_(std::move(file)) {}

  Result<CameraModel> read(const YAML::Node& root) {
    if (!root.IsMap()) {
      add({}, "", "this is no description of a camera", kPage);
      return Error(ErrorKind::kCaller, std::move(problems_));
    }
    const auto is = [&](const char* key, const char* wanted) {
      const YAML::Node node = root[key];
      if (node && node.IsScalar() && node.Scalar() == wanted) return;
      add(node, key, "only cameras with this are known", fmt::format("write {}", wanted));
    };
    is("camera_model", "pinhole");
    is("distortion_model", "radial-tangential");
    CameraModel camera;
    const std::vector<double> resolution = numbers(root, "resolution", 2);
    const std::vector<double> intrinsics = numbers(root, "intrinsics", 4);
    const std::vector<double> distortion = numbers(root, "distortion_coefficients", 4);
    const YAML::Node placed = root["T_BS"];
    const std::vector<double> matrix = placed && placed.IsMap() ? numbers(placed, "data", 16) : std::vector<double>();
    if (!placed || !placed.IsMap()) add(placed, "T_BS", "where the camera is on the body is missing", kPage);
    if (problems_.empty()) {
      constexpr double kMaxSide = 10'000.0;
      for (const double side : resolution) {
        if (side < 1.0 || side > kMaxSide || side != std::floor(side)) {
          add(root["resolution"], "resolution", fmt::format("a side of {} pixels", side), "write whole numbers");
        }
      }
      if (intrinsics[0] <= 0.0 || intrinsics[1] <= 0.0) {
        add(root["intrinsics"], "intrinsics", "focal lengths must be above 0", "write [fu, fv, cu, cv]");
      }
      place(matrix, placed["data"], camera.body_from_camera);
    }
    if (!problems_.empty()) return Error(ErrorKind::kCaller, std::move(problems_));
    camera.width = static_cast<int>(resolution[0]);
    camera.height = static_cast<int>(resolution[1]);
    camera.fx = intrinsics[0];
    camera.fy = intrinsics[1];
    camera.cx = intrinsics[2];
    camera.cy = intrinsics[3];
    camera.k1 = distortion[0];
    camera.k2 = distortion[1];
    camera.p1 = distortion[2];
    camera.p2 = distortion[3];
    return camera;
  }

 private:
  void add(const YAML::Node& node, const std::string& key, std::string what, std::string hint) {
    const bool known = node.IsDefined() && !node.Mark().is_null();
    const Place at{file_, known ? node.Mark().line + 1 : 1, known ? node.Mark().column + 1 : 1};
    problems_.push_back({at, key, std::move(what), std::move(hint)});
  }
  std::vector<double> numbers(const YAML::Node& map, const char* key, std::size_t count) {
    std::vector<double> result;
    const YAML::Node list = map[key];
    if (list && list.IsSequence()) {
      for (const YAML::Node& node : list) {
        double number = 0.0;
        if (!node.IsScalar() || !read_number(std::string_view(node.Scalar()), number) || !std::isfinite(number)) break;
        result.push_back(number);
      }
      if (list.size() == count && result.size() == count) return result;
    }
    add(list, key, fmt::format("there should be {} numbers", count), kPage);
    return {};
  }
  void place(const std::vector<double>& matrix, const YAML::Node& node, Pose& pose) {
    Eigen::Matrix3d rotation;
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column < 3; ++column) {
        rotation(row, column) = matrix[static_cast<std::size_t>(4 * row + column)];
      }
      pose.position[row] = matrix[static_cast<std::size_t>(4 * row + 3)];
    }
    constexpr double kRounding = 1e-4;
    const bool turns = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < kRounding &&
                       rotation.determinant() > 0.0;
    if (!turns) add(node, "T_BS.data", "the left upper 3 x 3 numbers are no rotation", kPage);
    pose.orientation = Eigen::Quaterniond(rotation).normalized();
  }

  std::string file_;
  std::vector<Problem> problems_;
};

State state_at(const TimedState& timed, std::int64_t origin) {
  State state = timed.state;
  state.time = seconds(timed.nanoseconds - origin);
  return state;
}

}  // namespace

Result<std::vector<TimedImu>> parse_euroc_imu(std::string_view text, const std::string& file) {
  Table table(text, file, 7);
  std::vector<TimedImu> rows;
  std::vector<double> numbers;
  while (table.next()) {
    if (!table.numbers(numbers)) continue;
    rows.push_back({table.time(), {0.0, vector_of(numbers, 0), vector_of(numbers, 3)}});
  }
  return table.finish(std::move(rows));
}

Result<std::vector<TimedName>> parse_euroc_pictures(std::string_view text, const std::string& file) {
  Table table(text, file, 2);
  std::vector<TimedName> rows;
  while (table.next()) {
    const std::string_view name = table.text(1);
    if (name.empty() || name.front() == '.' || name.find('/') != std::string_view::npos) {
      table.add(fmt::format("'{}' is no name of a picture", name), "write that of a file in cam0/data");
      continue;
    }
    rows.push_back({table.time(), std::string(name)});
  }
  return table.finish(std::move(rows));
}

Result<std::vector<TimedState>> parse_euroc_truth(std::string_view text, const std::string& file) {
  Table table(text, file, 17);
  std::vector<TimedState> rows;
  std::vector<double> numbers;
  while (table.next()) {
    if (!table.numbers(numbers)) continue;
    State state;
    state.pose.position = vector_of(numbers, 0);
    state.pose.orientation = Eigen::Quaterniond(numbers[3], numbers[4], numbers[5], numbers[6]);
    constexpr double kRounding = 1e-2;
    if (std::abs(state.pose.orientation.norm() - 1.0) > kRounding) {
      table.add(fmt::format("the orientation's length is {:.3f}", state.pose.orientation.norm()),
                "write a quaternion of length 1: w, x, y, z in fields 5 to 8");
      continue;
    }
    state.pose.orientation.normalize();
    state.velocity = vector_of(numbers, 7);
    state.gyro_bias = vector_of(numbers, 10);
    state.accelerometer_bias = vector_of(numbers, 13);
    rows.push_back({table.time(), state});
  }
  return table.finish(std::move(rows));
}

Result<CameraModel> parse_euroc_camera(std::string_view text, const std::string& file) {
  std::string yaml(text);
  // OpenCV's first line, %YAML:1.0, is none of YAML's; as a comment it leaves the lines' numbers as they are.
  if (yaml.starts_with('%')) yaml.front() = '#';
  try {
    return CameraReader(file).read(YAML::Load(yaml));
  } catch (const YAML::Exception& failure) {
    const int line = failure.mark.is_null() ? 1 : failure.mark.line + 1;
    return Error(ErrorKind::kCaller, {{{file, line, 0}, "", "this is not YAML: " + failure.msg, kPage}});
  }
}

Result<Euroc> read_euroc(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path inner = fs::path(folder) / "mav0";
  const fs::path root = fs::is_directory(inner, ignored) ? inner : fs::path(folder);
  if (!fs::is_directory(root / "imu0", ignored)) {
    return Error::caller("no data set in " + folder, "give a folder that has mav0/imu0 in it; " + std::string(kPage));
  }
  Euroc result;
  std::vector<TimedImu> imu;
  std::vector<TimedName> names;
  std::vector<TimedState> states;
  std::vector<Problem> problems;
  const std::string truth = (root / "state_groundtruth_estimate0" / "data.csv").string();
  const bool has_truth = fs::exists(truth, ignored);
  result.files = {(root / "imu0" / "data.csv").string(), (root / "cam0" / "data.csv").string(),
                  (root / "cam0" / "sensor.yaml").string()};
  for (const Status& status : {read(result.files[0], parse_euroc_imu, imu, problems),
                               read(result.files[1], parse_euroc_pictures, names, problems),
                               read(result.files[2], parse_euroc_camera, result.camera, problems),
                               has_truth ? read(truth, parse_euroc_truth, states, problems) : Status(Done{})}) {
    if (!status) return status.error();
  }
  if (has_truth) result.files.push_back(truth);
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));

  result.origin = imu.front().nanoseconds;
  for (TimedImu& row : imu) {
    row.sample.time = seconds(row.nanoseconds - result.origin);
    result.imu.push_back(row.sample);
  }
  for (const TimedName& row : names) {
    result.pictures.push_back({seconds(row.nanoseconds - result.origin), (root / "cam0" / "data" / row.name).string()});
  }
  for (const TimedState& row : states) result.truth.push_back(state_at(row, result.origin));
  return result;
}

std::vector<TimedPose> poses_of(const std::vector<State>& states) {
  std::vector<TimedPose> poses;
  for (const State& state : states) poses.push_back({state.time, state.pose});
  return poses;
}

}  // namespace ctn::vr::world
