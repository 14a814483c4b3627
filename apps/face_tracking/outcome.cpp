#include "outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "program/snapshot_json.h"

namespace ctn::face_tracking {
namespace {

using Json = nlohmann::ordered_json;

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

ChainSnapshot chain_of(const Snapshot& snapshot) {
  return snapshot.chains.empty() ? ChainSnapshot{} : snapshot.chains.front();
}

NodeSnapshot node_of(const Snapshot& snapshot, const std::string& name) {
  const auto found = std::ranges::find(snapshot.nodes, name, &NodeSnapshot::name);
  return found == snapshot.nodes.end() ? NodeSnapshot{} : *found;
}

}  // namespace

std::string to_json(const Outcome& outcome) {
  const Snapshot& snapshot = outcome.snapshot;
  const ChainSnapshot chain = chain_of(snapshot);
  Json compute = Json::object();
  Json compute_p95 = Json::object();
  Json rates = Json::object();
  for (const char* name : {"camera", "detect", "plan", "motor"}) {
    const NodeSnapshot node = node_of(snapshot, name);
    compute[name] = node.compute_ms.mean;
    compute_p95[name] = node.compute_ms.p95;
    rates[name] = node.rate_hz;
  }
  Json json = {
      {"scheduler", outcome.options.scheduler},
      {"cpus", outcome.options.cpus},
      {"seconds", outcome.seconds},
      {"speed_rad_s", outcome.options.speed},
      {"seed", outcome.options.seed},
      {"slowdown", outcome.options.slowdown},
      {"real_time", snapshot.real_time},
      {"response_time_ms", program::json_of(chain.response_ms)},
      {"predicted_response_time_ms", program::or_null(chain.predicted_response_ms)},
      {"source_hz", snapshot.source_hz},
      {"angle_deg_mean", degrees(outcome.tracking.angle_mean)},
      {"lost_fraction", outcome.tracking.lost_fraction},
      {"compute_ms", compute},
      {"compute_ms_p95", compute_p95},
      {"latency_ms", program::json_of(chain.latency_ms)},
      {"period_ms", program::json_of(chain.period_ms)},
      {"rate_hz", rates},
      {"pictures", outcome.sightings.pictures},
      {"pictures_in_view", outcome.sightings.in_view},
      {"pictures_found", outcome.sightings.found},
      {"pictures_wrong", outcome.sightings.wrong},
      {"plans", snapshot.plans},
      {"interrupted", outcome.signal != 0},
      {"notices", snapshot.notices},
  };
  if (outcome.options.virtual_time) {
    json["virtual"] = true;
    json["cores"] = outcome.options.cores;
  }
  return program::text_of(json);
}

std::string to_text(const Outcome& outcome) {
  const Snapshot& snapshot = outcome.snapshot;
  const ChainSnapshot chain = chain_of(snapshot);
  const Summary& response = chain.response_ms;
  std::string machine;
  if (outcome.options.virtual_time) {
    machine =
        fmt::format(", in virtual time on {} core{}", outcome.options.cores, outcome.options.cores == 1 ? "" : "s");
  }
  std::string text = fmt::format("face tracking under '{}', {:.1f} s, face at {} rad/s, slowdown {}{}{}\n",
                                 outcome.options.scheduler, outcome.seconds, outcome.options.speed,
                                 outcome.options.slowdown, machine, outcome.signal != 0 ? " (interrupted)" : "");
  text += fmt::format("  real-time levels  {}\n", snapshot.real_time ? "enforced" : "not used");
  text += fmt::format("  source            {:.2f} Hz\n", snapshot.source_hz);
  text += fmt::format("  response time     {:.1f} ms mean, {:.1f} p50, {:.1f} p95", response.mean, response.p50,
                      response.p95);
  if (chain.predicted_response_ms) text += fmt::format("; predicted {:.1f}", *chain.predicted_response_ms);
  text += fmt::format("\n  angle             {:.2f} deg mean\n", degrees(outcome.tracking.angle_mean));
  text += fmt::format("  face lost         {:.1f} % of the time\n", 100.0 * outcome.tracking.lost_fraction);
  for (const NodeSnapshot& node : snapshot.nodes) {
    text += fmt::format("  {:<17} {:.2f} ms mean, {:.2f} p95, {:.2f} Hz\n", node.name, node.compute_ms.mean,
                        node.compute_ms.p95, node.rate_hz);
  }
  return text;
}

std::string status_line(double seconds, const Snapshot& snapshot, const Tracking& tracking) {
  if (!snapshot.warmed_up) return fmt::format("{:6.1f} s  warming up", seconds);
  const ChainSnapshot chain = chain_of(snapshot);
  std::string line =
      fmt::format("{:6.1f} s  {:.1f} Hz  response {:.0f} ms", seconds, snapshot.source_hz, chain.response_ms.mean);
  if (chain.predicted_response_ms) line += fmt::format(" (predicted {:.0f})", *chain.predicted_response_ms);
  return line +
         fmt::format("  angle {:.1f} deg  lost {:.1f} %", degrees(tracking.angle_mean), 100.0 * tracking.lost_fraction);
}

}  // namespace ctn::face_tracking
