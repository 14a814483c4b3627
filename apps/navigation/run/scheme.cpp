#include "run/scheme.h"

#include <string>
#include <utility>

#include "program/known_costs.h"

namespace ctn::navigation::run {
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
    Options measuring = program::measuring(options, costs);
    measuring.replay.clear();
    auto measured = run(measuring);
    if (!measured) return measured.error();
    if (measured->signal != 0) {
      scheme.interrupted_ = std::move(measured).value();
      return scheme;
    }
  }
  auto policy = program::policy_by_costs(options.scheduler, costs, options.app_file, program::has_one_core(options),
                                         *scheme.folder_);
  if (!policy) return policy.error();
  scheme.options_.policy = std::move(policy).value();
  return scheme;
}

}  // namespace ctn::navigation::run
