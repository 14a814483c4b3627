#include "batches.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::case_studies {
namespace {

Batch batch_under(const Scheduler& scheduler, const Conditions& conditions) {
  return {.name = scheduler.name,
          .label = scheduler.label,
          .group = {},
          .reference = scheduler.name == std::string(kCatan.name),
          .arguments = arguments_of(conditions, scheduler),
          .runs = conditions.runs,
          .costs = scheduler.costs,
          .seconds = conditions.seconds};
}

}  // namespace

Conditions conditions_of(const Setting& setting, Arguments world, Size whole, Size quick) {
  const Size size = setting.quick ? quick : whole;
  return {.world = std::move(world),
          .seconds = std::min(size.seconds, setting.max_seconds),
          .runs = std::min(size.runs, setting.max_runs),
          .where = in_virtual_time(1)};
}

Arguments in_virtual_time(int cores) { return {"--virtual", "--cores", std::to_string(cores)}; }

Arguments arguments_of(const Conditions& conditions, const Scheduler& scheduler) {
  Arguments arguments = conditions.world;
  arguments.insert(arguments.end(),
                   {"--seconds", fmt::format("{}", conditions.seconds), "--scheduler", scheduler.option});
  if (!scheduler.stealing) arguments.emplace_back("--no-stealing");
  for (const Arguments& more : {conditions.where, conditions.more}) {
    arguments.insert(arguments.end(), more.begin(), more.end());
  }
  return arguments;
}

std::vector<Batch> batches_of(const std::vector<Scheduler>& schedulers, const Conditions& conditions) {
  std::vector<Batch> batches;
  for (const Scheduler& scheduler : schedulers) batches.push_back(batch_under(scheduler, conditions));
  return batches;
}

void add_group(Study& study, const std::string& group, std::vector<Batch> batches) {
  for (Batch& batch : batches) {
    batch.name = group + "/" + batch.name;
    batch.group = group;
    study.batches.push_back(std::move(batch));
  }
}

void add_life(Study& study, const std::vector<Scheduler>& schedulers, Conditions conditions, int cpu) {
  for (const Scheduler& scheduler : schedulers) {
    std::vector<Batch> batches;
    for (const bool live : {false, true}) {
      conditions.where = live ? Arguments{"--cpus", std::to_string(cpu)} : in_virtual_time(1);
      Batch& batch = batches.emplace_back(batch_under(scheduler, conditions));
      batch.name = live ? "life" : "virtual";
      batch.label += live ? " in life" : " in virtual time";
      batch.reference = !live;
      batch.live = live;
      if (!live) batch.calibration = std::string(scheduler.name) + "/life";
    }
    add_group(study, scheduler.name, std::move(batches));
  }
}

Metric metric(std::string name, const std::string& figure, Better better, Method method, int digits) {
  return {.name = std::move(name),
          .value = [figure](const StoredRun& run) { return run.figure(figure); },
          .better = better,
          .method = method,
          .digits = digits};
}

}  // namespace ctn::case_studies
