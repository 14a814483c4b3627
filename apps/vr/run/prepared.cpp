#include "run/prepared.h"

#include <fmt/format.h>

#include <utility>

#include "program/inputs.h"
#include "program/known_costs.h"
#include "run/headset_app.h"

namespace ctn::vr::run {
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
  return result;
}

}  // namespace

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
    auto measured = measure(measuring(options, costs));
    if (!measured) return measured.error();
    if (measured->signal != 0) return Ready(std::move(measured).value());
  }
  auto policy = program::policy_by_costs(options.scheduler, costs, options.app_file, has_one_core(options), *folder_);
  if (!policy) return policy.error();
  ready.policy = std::move(policy).value();
  if (!options.costs.empty()) policy_ = ready.policy;
  return Ready(std::move(ready));
}

}  // namespace ctn::vr::run
