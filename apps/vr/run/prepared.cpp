#include "run/prepared.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "program/inputs.h"
#include "program/known_costs.h"
#include "run/exposures.h"
#include "run/headset_app.h"
#include "world/euroc.h"

namespace ctn::vr::run {
namespace {

// Sets what follows from the options' data set. Errors: those of reading it.
Status read_dataset(Options& options) {
  const auto dataset = world::read_euroc(options.dataset);
  if (!dataset) return dataset.error();
  options.recorded = clock_of(dataset->pictures);
  std::vector<double> samples;
  for (const ImuSample& sample : dataset->imu) samples.push_back(sample.time);
  if (const auto clock = clock_of(samples)) options.recorded_samples = clock->period;
  std::vector<std::string> files = dataset->files;
  for (const world::PictureFile& picture : dataset->pictures) {
    // The others are not looked at, and a whole data set is a gigabyte.
    if (picture.time <= options.seconds) files.push_back(picture.path);
  }
  options.inputs["dataset"] = program::fingerprint_of_files(files);
  return Done{};
}

}  // namespace

Result<Prepared> Prepared::make(const Options& options) {
  auto folder = program::TemporaryFolder::make("vr");
  if (!folder) return folder.error();
  Prepared prepared;
  prepared.options_ = options;
  prepared.folder_ = std::move(folder).value();
  Options& made = prepared.options_;
  if (!made.dataset.empty()) {
    if (Status read = read_dataset(made); !read) return read.error();
  }
  if (made.app_file.empty()) {
    auto path = prepared.folder_->write("headset.yaml", app_text(made));
    if (!path) return path.error();
    made.app_file = std::move(path).value();
  }
  if (Status read = program::read_calibration(made); !read) return read.error();
  made.inputs.merge(program::fingerprints_of({{"app", made.app_file}, {"costs", made.costs}}));
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
