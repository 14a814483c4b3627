#include "run/scheme.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "catan/planning.h"

namespace ctn::navigation::run {
namespace {

constexpr const char* kFullRun = "static-full-run";
constexpr const char* kFirstSeconds = "static-20s";
constexpr double kFirst = 20.0;

bool is_static(const std::string& scheduler) { return scheduler == kFullRun || scheduler == kFirstSeconds; }

bool has_one_core(const Options& options) {
  return options.virtual_time ? options.cores == 1 : options.cpus.size() == 1;
}

// A run whose record says what these options' runs cost.
Options measuring(const Options& options, const std::string& record) {
  Options result = options;
  result.scheduler = result.policy = "catan";
  result.stealing = true;
  result.cores = 1;
  if (!options.virtual_time) result.cpus.resize(1);
  if (options.scheduler == kFirstSeconds) result.seconds = std::min(options.seconds, kFirst);
  result.record = record;
  result.pictures.clear();
  result.replay.clear();
  return result;
}

}  // namespace

bool needs_costs(const std::string& scheduler) {
  constexpr std::array<const char*, 4> kMethods{"davare", "verucchi", "picas", "deadline"};
  return is_static(scheduler) || std::ranges::find(kMethods, scheduler) != kMethods.end();
}

class Scheme::Folder {
 public:
  static Result<std::shared_ptr<Folder>> make() {
    std::error_code error;
    std::string path = (std::filesystem::temp_directory_path(error) / "navigation-XXXXXX").string();
    if (error || mkdtemp(path.data()) == nullptr) {
      return Error::environment("cannot make a folder for temporary files",
                                "name one in TMPDIR that can be written to");
    }
    return std::make_shared<Folder>(std::move(path));
  }
  explicit Folder(std::string path) : path_(std::move(path)) {}
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  std::string file(const char* name) const { return (std::filesystem::path(path_) / name).string(); }

 private:
  std::string path_;
};

Result<Scheme> Scheme::prepare(const Options& options, const std::function<Result<Outcome>(const Options&)>& run) {
  Scheme scheme;
  scheme.options_ = options;
  if (!needs_costs(options.scheduler)) return scheme;
  auto folder = Folder::make();
  if (!folder) return folder.error();
  scheme.folder_ = std::move(folder).value();

  std::string costs = options.costs;
  if (costs.empty()) {
    costs = scheme.folder_->file("measured.catan");
    auto measured = run(measuring(options, costs));
    if (!measured) return measured.error();
    if (measured->signal != 0) {
      scheme.interrupted_ = std::move(measured).value();
      return scheme;
    }
  }
  if (!is_static(options.scheduler)) {
    scheme.options_.policy = options.scheduler + ":" + costs;
    return scheme;
  }
  const auto plan = make_plan(options.app_file, {.costs = costs, .cores = 1});
  if (!plan) return plan.error();
  const std::string path = scheme.folder_->file("plan.json");
  if (!(std::ofstream(path) << *plan).flush()) {
    return Error::environment("cannot write " + path, "name a folder in TMPDIR that can be written to");
  }
  scheme.options_.policy = (has_one_core(options) ? "static:" : "rates-of:") + path;
  return scheme;
}

}  // namespace ctn::navigation::run
