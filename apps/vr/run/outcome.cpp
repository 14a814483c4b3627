#include "run/outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include <nlohmann/json.hpp>

#include "program/snapshot_json.h"
#include "run/findings.h"

namespace ctn::vr::run {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::nanoseconds;

// The paper's chains, by the nodes that ours have in common with them.
struct Named {
  const char* name;
  std::vector<std::string> path;
};
const std::vector<Named>& named_chains() {
  static const std::vector<Named> kChains{{"A", {"IMU", "Int", "Timewarp", "display"}},
                                          {"B", {"IMU", "Int", "Render", "Timewarp", "display"}},
                                          {"C", {"Camera", "VIO", "Int", "Timewarp", "display"}}};
  return kChains;
}

const ChainSnapshot* find_chain(const Snapshot& snapshot, const std::vector<std::string>& path) {
  for (const ChainSnapshot& chain : snapshot.chains) {
    // The camera's own clock stands before it.
    if (std::ranges::equal(chain.path, path) ||
        (chain.path.size() == path.size() + 1 && std::equal(path.begin(), path.end(), chain.path.begin() + 1))) {
      return &chain;
    }
  }
  return nullptr;
}

// What computing on the way takes, on average.
nanoseconds cost_of(const Snapshot& snapshot, const std::vector<std::string>& path) {
  double ms = 0.0;
  for (const NodeSnapshot& node : snapshot.nodes) {
    if (std::ranges::find(path, node.name) != path.end()) ms += node.compute_ms.mean;
  }
  return nanoseconds(std::llround(1e6 * ms));
}

// Of the chain that begins with that node. None: its clock is not known, or nothing was tracked.
std::optional<double> floor_of(const Outcome& outcome, const Named& named, const Clocks& clocks,
                               const std::vector<nanoseconds>& tracking) {
  if (named.path.front() == "IMU") {
    return floor_ms(clocks.samples, clocks.display, cost_of(outcome.snapshot, named.path));
  }
  if (!clocks.exposures || tracking.empty()) return std::nullopt;
  const AfterTracking after{clocks.samples, cost_of(outcome.snapshot, {"IMU"}),
                            cost_of(outcome.snapshot, {"Int", "Timewarp"})};
  return camera_floor_ms(*clocks.exposures, tracking, after, clocks.display);
}

Json json_of(const Options& options) {
  Json json = {{"scheduler", options.scheduler},
               {"stealing", options.stealing},
               {"width", options.width},
               {"height", options.height},
               {"hz", options.hz},
               {"camera_hz", program::or_null(options.camera_hz)},
               {"warp", options.translational ? "translational" : "rotational"},
               {"seconds", options.seconds},
               {"seed", options.seed},
               {"drift_ppm", options.drift_ppm},
               {"slowdown", options.slowdown},
               {"tracking_slowdown", options.tracking_slowdown},
               {"dataset", options.dataset},
               {"virtual", options.virtual_time}};
  program::add_machine(options, json);
  return json;
}

}  // namespace

void add_responses(Outcome& outcome, const Clocks& clocks, const std::vector<nanoseconds>& tracking) {
  for (const Named& named : named_chains()) {
    const ChainSnapshot* chain = find_chain(outcome.snapshot, named.path);
    const bool any = chain != nullptr && chain->response_ms.count > 0;
    const std::string name = std::string("response_ms ") + named.name;
    outcome.figures.push_back({name + "_mean", any ? std::optional(chain->response_ms.mean) : std::nullopt});
    outcome.figures.push_back({name + "_p95", any ? std::optional(chain->response_ms.p95) : std::nullopt});
    const std::optional<double> floor = floor_of(outcome, named, clocks, tracking);
    if (!floor) continue;
    outcome.figures.push_back({std::string("floor_ms ") + named.name, floor});
    std::optional<double> over;
    if (any && *floor > 0.0) over = 100.0 * (chain->response_ms.mean / *floor - 1.0);
    outcome.figures.push_back({std::string("over_floor_percent ") + named.name, over});
  }
}

std::string identity_of(const Options& options) { return json_of(options).dump(); }

std::string common_of(const Options& options) { return program::text_of(program::in_common(json_of(options))); }

std::string to_json(const Outcome& outcome) {
  const Options& options = outcome.options;
  Json json = json_of(options);
  if (!options.virtual_time) json["real_time"] = outcome.snapshot.real_time;
  program::add_in_common(json_of(options), json);
  json["interrupted"] = outcome.signal != 0;
  json["figures"] = program::json_of(outcome.figures);
  json["relax_factor"] = outcome.snapshot.relax_factor;
  program::add_snapshot(outcome.snapshot, outcome.cost_ratios, json);
  if (outcome.display_thread) json["display_thread"] = program::json_of(*outcome.display_thread);
  return program::text_of(json);
}

std::string to_text(const Outcome& outcome) {
  const Options& options = outcome.options;
  const std::string machine = program::machine_of(options.virtual_time, options.cores, outcome.snapshot);
  std::string text =
      fmt::format("{} under '{}'{}, {}{}\n", note_of(options), options.scheduler,
                  options.stealing ? "" : " without stealing", machine, outcome.signal != 0 ? ", interrupted" : "");
  text += program::list_of(outcome.figures);
  text += program::table_of_nodes(outcome.snapshot, outcome.cost_ratios);
  if (outcome.display_thread) {
    text += fmt::format("  display's thread: {:.2f} % of a CPU; ticks told at most {:.1f} ms late\n",
                        100.0 * outcome.display_thread->cpu_share, outcome.display_thread->late_ms_max);
    if (outcome.display_thread->lost > 0) {
      text += fmt::format(
          "  LOST: the display's thread came too late for {} pictures and states, which the figures above do not know; "
          "leave it a CPU with --cpus\n",
          outcome.display_thread->lost);
    }
  }
  return text;
}

}  // namespace ctn::vr::run
