#include "run/prepared.h"

#include <fmt/format.h>

#include <utility>

#include "program/inputs.h"
#include "program/known_costs.h"
#include "run/headset_app.h"

namespace ctn::vr::run {
Result<Prepared> Prepared::make(const Options& options) {
  auto folder = program::TemporaryFolder::make("vr");
  if (!folder) return folder.error();
  Prepared prepared;
  prepared.options_ = options;
  prepared.folder_ = std::move(folder).value();
  Options& made = prepared.options_;
  if (made.app_file.empty()) {
    auto path = prepared.folder_->write("headset.yaml", app_text(options));
    if (!path) return path.error();
    made.app_file = std::move(path).value();
  }
  if (Status read = program::read_calibration(made); !read) return read.error();
  made.inputs = program::fingerprints_of({{"app", made.app_file}, {"costs", made.costs}});
  return prepared;
}

Result<Prepared::Ready> Prepared::for_run(const Options& options,
                                          const std::function<Result<Outcome>(const Options&)>& measure) {
  Options ready = options;
  if (!program::needs_costs(options.scheduler)) return Ready(std::move(ready));
  if (!policy_.empty()) {
    ready.policy = policy_;
    return Ready(std::move(ready));
  }
  std::string costs = options.costs;
  if (costs.empty()) {
    costs = folder_->file(fmt::format("measured-{}.catan", options.seed));
    auto measured = measure(program::measuring(options, costs));
    if (!measured) return measured.error();
    if (measured->signal != 0) return Ready(std::move(measured).value());
  }
  auto policy =
      program::policy_by_costs(options.scheduler, costs, options.app_file, program::has_one_core(options), *folder_);
  if (!policy) return policy.error();
  ready.policy = std::move(policy).value();
  if (!options.costs.empty()) policy_ = ready.policy;
  return Ready(std::move(ready));
}

}  // namespace ctn::vr::run
