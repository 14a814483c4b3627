#include "sim_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "sim/batch.h"

namespace ctn::tool {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kAppEnding = ".yaml";
constexpr const char* kCosts = ".costs.yaml";

// Names, sorted.
Result<std::vector<std::string>> apps_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string file = entry.path().filename().string();
    if (file.ends_with(kCosts) || !file.ends_with(kAppEnding)) continue;
    std::string name = file.substr(0, file.size() - std::string(kAppEnding).size());
    if (fs::exists(fs::path(folder) / (name + kCosts))) names.push_back(std::move(name));
  }
  if (failed) return Error::caller(fmt::format("{}: {}", folder, failed.message()), "name a folder of apps");
  if (names.empty()) {
    return Error::caller(fmt::format("{} has no app", folder), "an app is NAME.yaml with NAME.costs.yaml beside it");
  }
  std::sort(names.begin(), names.end());
  return names;
}

// How many apps the file has already; what is left of it ends with a whole line.
Result<std::size_t> resume(const Sweep& what, const std::vector<std::string>& names) {
  std::ifstream file(what.out, std::ios::binary);
  if (!file) return std::size_t{0};
  std::vector<std::string> lines;
  std::uintmax_t whole = 0;
  for (std::string line; std::getline(file, line) && !file.eof();) {
    whole += line.size() + 1;
    lines.push_back(std::move(line));
  }
  file.close();
  const Error other = Error::caller(fmt::format("{} is not of this sweep", what.out),
                                    "give the same options and folder, or write into another file");
  if (lines.empty()) whole = 0;
  if (!lines.empty() && lines.front() != what.asked) return other;
  if (lines.size() > names.size() + 1) return other;
  for (std::size_t index = 1; index < lines.size(); ++index) {
    const Json json = Json::parse(lines[index], nullptr, false);
    if (!json.is_object() || json.value("app", "") != names[index - 1]) return other;
  }
  std::error_code failed;
  fs::resize_file(what.out, whole, failed);
  if (failed) return Error::environment(fmt::format("{}: {}", what.out, failed.message()), "write into another file");
  return lines.empty() ? 0 : lines.size() - 1;
}

std::string line_of(const std::string& name, const Result<std::string>& document) {
  Json line{{"app", name}};
  if (document) {
    line["result"] = Json::parse(*document);
  } else {
    line["error"] = document.error().message();
  }
  return line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Writes lines in their order, each as soon as those before it are there.
class Lines {
 public:
  Lines(const std::string& path, std::size_t first) : file_(path, std::ios::binary | std::ios::app), next_(first) {}

  void add(std::size_t index, std::string line) {
    if (waiting_.size() <= index) waiting_.resize(index + 1);
    waiting_[index] = std::move(line);
    while (next_ < waiting_.size() && waiting_[next_]) {
      file_ << *waiting_[next_];
      waiting_[next_++].reset();
    }
    file_.flush();
  }
  void first_line(const std::string& line) { file_ << line << "\n"; }
  bool good() { return file_.flush().good(); }

 private:
  std::ofstream file_;
  std::size_t next_;
  std::vector<std::optional<std::string>> waiting_;
};

}  // namespace

Result<Swept> sweep(const Sweep& what) {
  const auto names = apps_in(what.folder);
  if (!names) return names.error();
  const auto done = resume(what, *names);
  if (!done) return done.error();
  Swept swept{.apps = names->size(), .found_done = *done, .failed = 0};
  std::error_code none;
  const bool begun = fs::exists(what.out, none) && fs::file_size(what.out, none) > 0;
  Lines lines(what.out, *done);
  if (!begun) lines.first_line(what.asked);
  if (!lines.good()) return Error::environment(fmt::format("cannot write {}", what.out), "write into another file");
  std::mutex mutex;
  sim::Progress progress(
      [&](std::size_t finished) {
        if (what.on_progress) what.on_progress(finished, names->size());
      },
      *done);
  sim::for_each_in_parallel(names->size() - *done, what.threads, [&](std::size_t offset) {
    const std::size_t index = *done + offset;
    const std::string& name = names->at(index);
    const Result<std::string> document = what.simulate((fs::path(what.folder) / (name + kAppEnding)).string(),
                                                       (fs::path(what.folder) / (name + kCosts)).string());
    std::string line = line_of(name, document);
    {
      const std::lock_guard lock(mutex);
      lines.add(index, std::move(line));
      if (!document) ++swept.failed;
    }
    progress.add();
  });
  if (!lines.good())
    return Error::environment(fmt::format("cannot write {}", what.out), "make room, and go on with it");
  return swept;
}

}  // namespace ctn::tool
