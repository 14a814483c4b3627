#include "run/scheme.h"

#include <string>
#include <utility>

#include "program/known_costs.h"

namespace ctn::navigation::run {
namespace {

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
  result.seconds = program::measuring_seconds(options.scheduler, options.seconds);
  result.record = record;
  result.pictures.clear();
  result.replay.clear();
  return result;
}

}  // namespace

Result<Scheme> Scheme::prepare(const Options& options, const std::function<Result<Outcome>(const Options&)>& run) {
  Scheme scheme;
  scheme.options_ = options;
  if (!program::needs_costs(options.scheduler)) return scheme;
  auto folder = program::TemporaryFolder::make("navigation");
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
  auto policy =
      program::policy_by_costs(options.scheduler, costs, options.app_file, has_one_core(options), *scheme.folder_);
  if (!policy) return policy.error();
  scheme.options_.policy = std::move(policy).value();
  return scheme;
}

}  // namespace ctn::navigation::run
