// What a developer wrote, before it is checked: names are still text, and each value remembers where it stands.
// `config` fills it from YAML; programs and tests may fill it by hand and leave the places empty. `build_app` (build.h)
// turns it into an `App` or into the list of everything that is wrong with it.
//
// Units: durations are Nanos, rates are Rate. Thread safety: plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::graph {

// A value and where it was written.
template <class T>
struct At {
  T value;
  Place place;
};
using Name = At<std::string>;

struct NodeSpec {
  Name name;
  InputKind input = InputKind::kLatest;
  std::vector<Name> modes;
  bool external = false;
  bool unscheduled = false;
  std::optional<At<Nanos>> period;
  std::optional<At<Nanos>> output_period;
  std::optional<At<Rate>> min_rate;
  std::optional<At<Rate>> max_rate;
  std::optional<At<Rate>> fallback_rate;
  std::optional<At<int>> max_threads;
  std::optional<At<TriggerBy>> trigger;
  bool needs_input = false;  // of an external node it counts for nothing
};

// A row of node names: in `edges` a path stands for its edges. What it says of age holds for each of them.
struct PathSpec {
  std::vector<Name> nodes;
  Place place;
  std::optional<At<Nanos>> max_age{};
  std::optional<At<OnStale>> on_stale{};
};

struct SubchainSpec {
  Name name;
  std::vector<Name> nodes;
};

struct TermSpec {
  Metric metric = Metric::kResponseTime;
  std::vector<Name> path;  // a response time's nodes in order; a period's one node
  At<double> weight{};
  std::optional<At<Nanos>> max;
  Place place;
};

struct ExclusiveGroupSpec {
  Name name;
  std::vector<Name> nodes;
};

struct CoreKindSpec {
  Name name;
  At<int> count{1, {}};
  At<double> speed{1.0, {}};
};

struct AppSpec {
  Name name;
  std::vector<CoreKindSpec> core_kinds;
  std::vector<NodeSpec> nodes;
  std::vector<PathSpec> edges;
  std::vector<SubchainSpec> subchains;
  std::vector<ExclusiveGroupSpec> exclusive;
  std::vector<TermSpec> objective;
  std::optional<std::vector<Name>> order;
  std::optional<std::vector<Name>> steal_priority;
  std::vector<Name> steal_off;
  SchedulerOptions scheduler;  // each value's range is checked where it is read
};

}  // namespace ctn::graph
