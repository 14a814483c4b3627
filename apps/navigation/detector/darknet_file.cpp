#include "detector/darknet_file.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

namespace ctn::navigation {
namespace {

constexpr int kNetStride = 32;  // what networks of this kind scale their input down by
constexpr int kMaxSide = 2048;  // pixels: a mistyped size must not use up the machine's memory
constexpr int kMaxClasses = 10000;

std::string without_blanks(std::string_view line) {
  std::string out;
  for (const char letter : line) {
    if (letter == '#' || letter == ';') break;
    if (letter != ' ' && letter != '\t' && letter != '\r') out += letter;
  }
  return out;
}

class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  void line(int number, std::string_view text) {
    if (text.starts_with('[')) {
      section_ = text;
      first_ = first_.empty() ? section_ : first_;
      return;
    }
    const std::size_t sign = text.find('=');
    if (sign == std::string_view::npos) return;
    const std::string_view key = text.substr(0, sign);
    const std::string_view value = text.substr(sign + 1);
    if (in_net() && key == "width") read(number, "net.width", value, kNetStride, kMaxSide, kNetStride, file_.width);
    if (in_net() && key == "height") read(number, "net.height", value, kNetStride, kMaxSide, kNetStride, file_.height);
    if (in_net() && key == "channels" && value != "3") {
      complain(number, "net.channels", fmt::format("the network takes pictures of {} channels", value),
               "the camera's have colours: use a network with channels=3");
    }
    if (at_output() && key == "classes") classes(number, value);
  }

  Result<DarknetFile> end() {
    if (first_ != "[net]" && first_ != "[network]") {
      return Error(ErrorKind::kCaller, {{{path_},
                                         {},
                                         "this is no description of a Darknet network: no section [net]",
                                         "give the network's .cfg first, then its .weights"}});
    }
    if (problems_.empty() && (file_.width == 0 || file_.height == 0)) {
      complain(0, "net", "width or height is missing", "write the size of the network's input, such as width=416");
    }
    if (problems_.empty() && file_.classes == 0) {
      complain(0, {}, "the network has no section [yolo] or [region] with classes, so it detects nothing",
               "use a detector such as YOLO, not a classifier");
    }
    if (!problems_.empty()) return Error(ErrorKind::kCaller, std::move(problems_));
    return file_;
  }

 private:
  bool in_net() const { return section_ == "[net]" || section_ == "[network]"; }
  bool at_output() const { return section_ == "[yolo]" || section_ == "[region]"; }

  void complain(int number, std::string key, std::string what, std::string hint) {
    problems_.push_back({{path_, number, 0}, std::move(key), std::move(what), std::move(hint)});
  }

  void read(int number, const char* key, std::string_view text, int min, int max, int step, int& into) {
    int value = 0;
    const auto [rest, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed == std::errc{} && rest == text.data() + text.size() && value >= min && value <= max &&
        value % step == 0) {
      into = value;
      return;
    }
    complain(number, key, fmt::format("'{}' is not possible", text),
             step > 1 ? fmt::format("write a multiple of {} from {} to {}", step, min, max)
                      : fmt::format("write a whole number from {} to {}", min, max));
  }

  void classes(int number, std::string_view text) {
    const int before = file_.classes;
    read(number, "yolo.classes", text, 1, kMaxClasses, 1, file_.classes);
    if (before != 0 && before != file_.classes) {
      complain(number, "yolo.classes", fmt::format("{} classes, but {} in a section before", file_.classes, before),
               "all outputs of a network know the same classes");
    }
  }

  std::string path_;
  std::string section_;
  std::string first_;
  DarknetFile file_;
  std::vector<Problem> problems_;
};

}  // namespace

Result<DarknetFile> read_darknet(const std::string& text, const std::string& path) {
  Reader reader(path);
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) reader.line(++number, without_blanks(line));
  return reader.end();
}

}  // namespace ctn::navigation
