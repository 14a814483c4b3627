#include "contest.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <memory>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "api/policies.h"
#include "base/mixed.h"
#include "planner/expected.h"
#include "policy/planned.h"
#include "sim/simulation.h"
#include "trial/samples.h"

namespace ctn::bench {
namespace {

constexpr std::string_view kPlanned = "plan:auto";
// No simulation has it: their seeds are counted from 1 on.
constexpr std::uint64_t kSeedOfSamples = 0x5eed'0f5a'3b1e'5000;

// A plan that is made before.
struct Planned {
  double effort = 1.0;
  bool priorities = true;
  bool elastic = true;
  bool stealing = true;
  planner::Freedom freedom{};
};

bool set_effort(Planned& planned, std::string_view text) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), planned.effort);
  return error == std::errc{} && end == text.data() + text.size() && planned.effort > 0.0;
}

bool leave_out(Planned& planned, std::string_view feature) {
  const std::pair<std::string_view, bool*> features[] = {{"no-priorities", &planned.priorities},
                                                         {"no-elastic", &planned.elastic},
                                                         {"no-stealing", &planned.stealing},
                                                         {"no-phases", &planned.freedom.phases},
                                                         {"no-outputs", &planned.freedom.outputs}};
  for (const auto& [name, kept] : features) {
    if (name != feature) continue;
    *kept = false;
    return true;
  }
  return false;
}

// None: the contender is a policy, or nothing.
std::optional<Planned> planned_of(std::string_view contender) {
  if (!contender.starts_with(kPlanned)) return std::nullopt;
  std::string_view rest = contender.substr(kPlanned.size());
  Planned planned;
  for (bool first = true; !rest.empty(); first = false) {
    if (rest.front() != ':') return std::nullopt;
    rest.remove_prefix(1);
    const std::string_view part = rest.substr(0, rest.find(':'));
    if (!leave_out(planned, part) && !(first && set_effort(planned, part))) return std::nullopt;
    rest.remove_prefix(part.size());
  }
  return planned;
}

graph::App app_for(const Planned& planned, graph::App app) {
  if (!planned.priorities) app.scheduler.schedule = graph::ScheduleKind::kFrames;
  if (!planned.elastic) app.scheduler.frames = graph::FrameMode::kFixed;
  return app;
}

Result<api::SimulatedPolicy> policy_of(const std::string& contender, const std::optional<Planned>& planned,
                                       const graph::App& app, const model::Workload& work, int cores) {
  if (!planned) return api::simulated_policy(contender, app);
  const trial::Samples samples(app, work, Nanos{0}, kSeedOfSamples);
  Result<plan::Plan> plan = planner::make_expected_plan(app, samples, work.costs(app.graph),
                                                        {.cores = cores,
                                                         .slack = app.scheduler.slack.value_or(graph::kDefaultSlack),
                                                         .effort = planned->effort,
                                                         .freedom = planned->freedom});
  if (!plan) return plan.error();
  return api::SimulatedPolicy{std::make_shared<policy::StaticPolicy>(contender, std::move(*plan))};
}

// Of unscheduled nodes with a timer: any, within a period.
sim::Phases phases_of(const graph::App& app, std::uint64_t seed) {
  sim::Phases phases;
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    const graph::Node& node = app.graph.node(NodeId(i));
    phases.nodes.push_back(node.period ? chance_below(*node.period, seed, i) : Nanos{0});
  }
  return phases;
}

double p95_of_weightiest(const sim::Outcome& outcome) {
  const auto first = std::max_element(outcome.chains.begin(), outcome.chains.end(),
                                      [](const auto& a, const auto& b) { return a.weight < b.weight; });
  if (first == outcome.chains.end() || first->response_ms.count == 0) return kNotReached;
  return first->response_ms.p95;
}

Status play_all(const std::string& contender, const Case& of, const Match& match, Score& score) {
  const std::optional<Planned> planned = planned_of(contender);
  const graph::App app = planned ? app_for(*planned, of.app) : of.app;
  const Result<api::SimulatedPolicy> policy = policy_of(contender, planned, app, of.work, match.cores);
  if (!policy) return policy.error();
  for (const std::uint64_t seed : match.seeds) {
    sim::Options options{.policy = policy->policy,
                         .reserve = policy->reserve,
                         .machine = {.cores = match.cores},
                         .stealing = !planned || planned->stealing,
                         .costs = of.work.costs(app.graph),
                         .phases = phases_of(app, seed)};
    const Result<sim::Outcome> outcome =
        sim::simulate(app, std::make_unique<sim::DrawnCosts>(app, of.work, seed), std::move(options), match.measured);
    if (!outcome) return outcome.error();
    score.objective_ms.push_back(outcome->objective.value_or(kNotReached));
    score.p95_ms.push_back(p95_of_weightiest(*outcome));
  }
  return Done{};
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double Score::mean_objective() const { return mean(objective_ms); }
double Score::mean_p95() const { return mean(p95_ms); }

Status check_contender(const std::string& contender, const graph::App& app) {
  if (planned_of(contender)) return Done{};
  const Result<api::SimulatedPolicy> policy = api::simulated_policy(contender, app);
  if (!policy) return policy.error();
  return Done{};
}

Score play(const std::string& contender, const Case& of, const Match& match) {
  Score score;
  // A bug in one contender's planner should not end an hour's contest.
  try {
    if (const Status played = play_all(contender, of, match, score); !played) score.refused = played.error().message();
  } catch (const std::exception& error) {
    score.refused = fmt::format("failed: {}", error.what());
  }
  if (score.refused.empty()) return score;
  score.objective_ms.assign(match.seeds.size(), kNotReached);
  score.p95_ms = score.objective_ms;
  return score;
}

double ratio_to_best(double judged, const std::vector<double>& others) {
  double best = kNotReached;
  for (const double other : others) best = std::min(best, other);
  if (!std::isfinite(best)) return std::isfinite(judged) ? 0.0 : 1.0;
  return judged / best;
}

Ratios summary_of(const std::vector<double>& ratios) {
  Ratios result{.count = ratios.size()};
  if (ratios.empty()) return result;
  double logs = 0.0;
  std::size_t summed = 0;
  std::size_t within = 0;
  std::size_t first = 0;
  for (const double ratio : ratios) {
    result.infinite += std::isfinite(ratio) ? 0U : 1U;
    within += ratio <= 1.01 ? 1U : 0U;
    first += ratio <= 1.0 ? 1U : 0U;
    if (ratio == 0.0 || !std::isfinite(ratio)) continue;
    logs += std::log(ratio);
    ++summed;
  }
  if (summed > 0) result.geometric_mean = std::exp(logs / static_cast<double>(summed));
  result.within_a_percent = static_cast<double>(within) / static_cast<double>(ratios.size());
  result.first = static_cast<double>(first) / static_cast<double>(ratios.size());
  return result;
}

}  // namespace ctn::bench
