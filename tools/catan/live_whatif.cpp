#include "live_whatif.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/policies.h"
#include "base/text.h"
#include "config/quantity.h"
#include "graph/change.h"
#include "os/cpu_set.h"
#include "plan/json.h"
#include "policy/policy.h"
#include "policy/replan.h"
#include "record/app_changes.h"
#include "record/metrics_json.h"
#include "trial/samples.h"

namespace ctn::tool {
namespace {

using AnswerJson = nlohmann::ordered_json;

// CPU time of the search, as reckoned for an ordinary machine; and how long it may last where other threads have the
// CPUs.
constexpr Nanos kSearchWork = std::chrono::seconds{1};
constexpr Nanos kSearchWithin = std::chrono::seconds{3};
constexpr int kMaxSteps = 2000;
constexpr double kMaxTimes = 1000.0;
constexpr Nanos kLongest = std::chrono::hours{240};  // as in all other durations that users write
constexpr auto kLongestNanos = static_cast<double>(kLongest.count());

// ---- What is asked

// The CPUs to plan for: core k of a plan is the k-th of them. CPUs that do not exist get the next numbers.
Result<os::CpuSet> cpus_asked(const KnownSoFar& known, const web::WhatIf& asked) {
  const os::CpuSet& given = known.header().cpus;
  if (asked.changes.cpus && asked.cores) {
    return Error::caller("both `cpus` and `cores` are asked for", "ask for one of them");
  }
  if (asked.changes.cpus) {
    const os::CpuSet wanted(*asked.changes.cpus);
    if (wanted.empty() || os::common(wanted, given) != wanted) {
      return Error::caller(
          fmt::format("CPUs {} are not among those that the app was started with", os::to_string(wanted)),
          fmt::format("name some of {}, or a number of `cores`", os::to_string(given)));
    }
    return wanted;
  }
  const std::size_t planned = known.plan() ? known.plan()->cores.size() : given.size();
  const std::size_t count = asked.cores ? static_cast<std::size_t>(*asked.cores) : planned;
  if (count > given.size() && known.app().core_count()) {
    return Error::caller(fmt::format("the app lists its cores, and {} are more than these", count),
                         fmt::format("ask for {} at most", given.size()));
  }
  std::vector<int> cpus = given.cpus();
  cpus.resize(std::min(cpus.size(), count));
  for (int next = given.cpus().back() + 1; cpus.size() < count; ++next) cpus.push_back(next);
  return os::CpuSet(std::move(cpus));
}

struct AssumedCosts {
  model::CostTable planned;
  model::CostTable typical;
  trial::MeasuredRuns runs;
  std::vector<NodeId> unknown;  // nodes that have not run, and whose cost was not given
};

void multiply(model::CostTable& costs, const graph::App& app, NodeId node, double factor) {
  std::vector<model::CostProfile> on_kind;
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) on_kind.push_back(costs.on(app, kind)[node].times(factor));
  costs.set(node, costs[node].times(factor));
  if (app.core_kinds.empty()) return;
  for (std::size_t kind = 0; kind < app.kinds(); ++kind) costs.set_on(node, kind, std::move(on_kind[kind]));
}

// "x2", or "5ms" where a run costs `now`.
Result<double> factor_of(const web::WhatIf::Cost& cost, Millis now) {
  const std::string hint = "write a factor such as \"x2\", or a compute time such as \"5ms\"";
  if (cost.text.starts_with('x')) {
    double factor = 0.0;
    const char* const text_end = cost.text.data() + cost.text.size();
    const auto [end, error] = std::from_chars(cost.text.data() + 1, text_end, factor);
    if (error == std::errc() && end == text_end && factor > 0.0 && factor <= kMaxTimes) return factor;
    return Error::caller(fmt::format("costs.{}: {} is not a factor above 0, up to {}", printable(cost.node),
                                     quote(cost.text), kMaxTimes),
                         hint);
  }
  const Result<Nanos> duration = config::parse_duration(cost.text);
  if (!duration || *duration <= Nanos{0}) {
    return Error::caller(fmt::format("costs.{}: {} is not a compute time", printable(cost.node), quote(cost.text)),
                         hint);
  }
  return to_millis(*duration) / std::max(now, Millis{1e-6});
}

Result<AssumedCosts> costs_asked(const KnownSoFar& known, const web::WhatIf& asked) {
  const graph::App& app = known.app();
  const Millis unmeasured = app.scheduler.bootstrap_cost;
  const policy::MeasuredCosts& measured = known.measured();
  AssumedCosts costs{measured.costs(unmeasured), measured.typical_costs(unmeasured), measured.runs(),
                     measured.unknown()};
  for (const web::WhatIf::Cost& cost : asked.costs) {
    const std::optional<NodeId> node = app.graph.find_node(cost.node);
    if (!node || app.graph.node(*node).external) {
      return Error::caller(fmt::format("the app has no node {} that costs anything", quote(cost.node)),
                           "name one of its nodes");
    }
    const Result<double> factor = factor_of(cost, costs.planned[*node].single_thread());
    if (!factor) return factor.error();
    multiply(costs.planned, app, *node, *factor);
    multiply(costs.typical, app, *node, *factor);
    for (std::vector<model::RunTime>& kind : costs.runs[node->index()]) {
      for (model::RunTime& run : kind) {
        const double cpu = static_cast<double>(run.cpu.count()) * *factor;
        run.cpu = std::clamp(Nanos{std::llround(std::min(cpu, kLongestNanos))}, Nanos{1}, kLongest);
      }
    }
    if (!cost.text.starts_with('x')) std::erase(costs.unknown, *node);
  }
  return costs;
}

// ---- What is planned

Result<std::shared_ptr<const policy::Policy>> policy_of(const KnownSoFar& known) {
  const std::string& name = known.header().scheduler;
  const Error does_not_plan =
      Error::caller(fmt::format("the scheduler {} does not plan by what is measured", quote(name)),
                    "ask where catan, auto or paper schedules the app");
  if (name.find(':') != std::string::npos) return does_not_plan;
  Result<std::shared_ptr<const policy::Policy>> policy = api::live_policy(name, known.app());
  if (!policy) return policy.error();
  if (!(*policy)->follows_plan() || !(*policy)->adapts()) return does_not_plan;
  return policy;
}

// Plans as a session does after a change: at once, and then better with every step.
Result<plan::Plan> planned_for(const policy::Policy& policy, policy::Situation situation, os::Clock& clock) {
  const TimePoint until = clock.now() + kSearchWithin;
  const std::unique_ptr<policy::Memory> memory = policy.make_memory();
  situation.memory = memory.get();
  situation.why = policy::PlanReason::kAsked;
  Result<std::optional<policy::Decision>> first = policy::replacement(policy, situation, policy::Decision{});
  if (!first) return first.error();
  if (!*first || !(*first)->plan)
    return Error::caller("no plan was found for that", "loosen bounds, lower costs or rates, or ask for more cores");
  policy::Decision decision = std::move(**first);
  situation.why = policy::PlanReason::kPeriodic;
  for (int step = 1; memory && step <= kMaxSteps && memory->work() < kSearchWork && clock.now() < until; ++step) {
    if (!memory->more_to_do(situation.min_runs)) break;
    situation.periodic = step;
    Result<std::optional<policy::Decision>> better = policy::replacement(policy, situation, decision);
    if (better && *better && (*better)->plan) decision = std::move(**better);
  }
  return std::move(*decision.plan);
}

// ---- What is answered

AnswerJson plan_figures(const plan::Plan& plan) {
  AnswerJson relaxed = AnswerJson::array();
  for (const plan::RelaxedBound& bound : plan.relaxed) {
    relaxed.push_back({{"bound", bound.key}, {"asked_ms", bound.asked.count()}, {"planned_ms", bound.planned.count()}});
  }
  return {{"cores", plan.cores.size()},
          {"objective", plan.expected ? plan.expected->objective : plan.objective},
          {"promises_for", plan::promises_for(plan.for_typical)},
          {"feasible", plan.relax_factor <= 1.0},
          {"relax_factor", plan.relax_factor},
          {"relaxed", std::move(relaxed)}};
}

AnswerJson chain_json(const plan::Plan& plan, std::size_t chain) {
  AnswerJson expected = nullptr;
  if (plan.expected && chain < plan.expected->chains.size()) {
    expected = plan.expected->chains[chain].response.count();
  }
  return {{"expected_ms", expected}, {"promised_ms", plan.chains[chain].response.count()}};
}

AnswerJson subchain_json(const plan::Plan& plan, SubchainId id) {
  const plan::SubchainPlan& planned = plan.subchains[id.index()];
  const plan::Member* const member = plan::member_of(plan, id);
  const bool takes_turns = plan::shares_core(plan, planned);
  return {{"cores", planned.cores},
          {"priority", member != nullptr ? AnswerJson(member->priority) : AnswerJson(nullptr)},
          {"share", takes_turns ? AnswerJson(planned.share) : AnswerJson(nullptr)},
          {"period_ms", plan::usual_timing(plan, id).period.count()}};
}

std::string answer_json(const KnownSoFar& known, const graph::App& app, const plan::Plan& then,
                        const std::vector<NodeId>& unknown) {
  const plan::Plan* const now = known.plan() ? &*known.plan() : nullptr;
  AnswerJson chains = AnswerJson::array();
  std::size_t chain = 0;
  for (const graph::Term& term : app.objective) {
    if (term.metric != graph::Metric::kResponseTime) continue;
    std::optional<double> bound;
    if (term.max) bound = to_millis(*term.max).count();
    chains.push_back({{"path", app.graph.path_name(term.path)},
                      {"weight", term.weight},
                      {"bound_ms", record::or_null(bound)},
                      {"now", now != nullptr ? chain_json(*now, chain) : AnswerJson(nullptr)},
                      {"then", chain_json(then, chain)}});
    ++chain;
  }
  AnswerJson subchains = AnswerJson::array();
  for (std::size_t index = 0; index < app.graph.subchains().size(); ++index) {
    const SubchainId id(index);
    subchains.push_back({{"subchain", app.graph.subchain(id).name},
                         {"now", now != nullptr ? subchain_json(*now, id) : AnswerJson(nullptr)},
                         {"then", subchain_json(then, id)}});
  }
  AnswerJson assumed = AnswerJson::array();
  for (const NodeId node : unknown) assumed.push_back(app.graph.node(node).name);
  const AnswerJson answer{{"app", app.name},
                          {"now", now != nullptr ? plan_figures(*now) : AnswerJson(nullptr)},
                          {"then", plan_figures(then)},
                          {"assumed", std::move(assumed)},
                          {"chains", std::move(chains)},
                          {"subchains", std::move(subchains)}};
  return answer.dump(1, ' ', false, AnswerJson::error_handler_t::replace) + "\n";
}

std::size_t count_chains(const graph::App& app) {
  return static_cast<std::size_t>(
      std::count_if(app.objective.begin(), app.objective.end(),
                    [](const graph::Term& term) { return term.metric == graph::Metric::kResponseTime; }));
}

// Checks what plan::from_json() does not: the plan comes from the memory of another process.
bool can_be_shown(const plan::Plan& plan, const graph::App& app) {
  const auto has_core = [&](int core) { return core >= 0 && static_cast<std::size_t>(core) < plan.cores.size(); };
  return plan.chains.size() == count_chains(app) && plan.subchains.size() == app.graph.subchains().size() &&
         std::all_of(plan.subchains.begin(), plan.subchains.end(), [&](const plan::SubchainPlan& subchain) {
           return !subchain.cores.empty() && std::all_of(subchain.cores.begin(), subchain.cores.end(), has_core);
         });
}

}  // namespace

KnownSoFar::KnownSoFar(const graph::App& app, const record::Header& header)
    : header_(header),
      app_(app),
      kinds_(policy::CpuKinds::fits(app, header.cpus) ? policy::CpuKinds(app, header.cpus) : policy::CpuKinds()),
      measured_(app),
      clocks_(app.graph.nodes().size()) {}

void KnownSoFar::add(const record::PlanChange& change) {
  if (plan_ && change.at < plan_at_) return;
  Result<plan::Plan> plan = plan::from_json(change.json, app_, "the plan in force");
  if (!plan || !can_be_shown(*plan, app_)) return;
  plan_ = std::move(*plan);
  plan_at_ = change.at;
}

void KnownSoFar::add(const record::AppChange& change) {
  Result<graph::App> changed = record::app_after(app_, std::array{change});
  if (changed) app_ = std::move(*changed);
}

void KnownSoFar::add(const record::ClockReading& reading) { clocks_[reading.node.index()] = reading.ticks; }

Result<std::string> what_if(const KnownSoFar& known, const web::WhatIf& asked, os::Clock& clock) {
  if (known.header().cpus.empty()) {
    return Error::environment("the CPUs of the app are not known", "use the same version of Catan for both programs");
  }
  const Result<std::shared_ptr<const policy::Policy>> policy = policy_of(known);
  if (!policy) return policy.error();
  const Result<os::CpuSet> cpus = cpus_asked(known, asked);
  if (!cpus) return cpus.error();
  const Result<graph::App> changed = graph::changed(known.app(), asked.changes);
  if (!changed) return changed.error();
  const graph::App app = known.kinds().only_with(*changed, *cpus);
  const Result<AssumedCosts> costs = costs_asked(known, asked);
  if (!costs) return costs.error();
  const policy::Situation situation{
      .app = app,
      .cpus = *cpus,
      .costs = costs->planned,
      .typical = costs->typical,
      .slack = known.header().slack.value_or(app.scheduler.slack.value_or(graph::kDefaultSlack)),
      .stealing = known.header().stealing,
      .assumed = costs->unknown,
      .runs = &costs->runs,
      .min_runs = known.measured().min_runs(),
      .clocks = known.clocks()};
  const Result<plan::Plan> plan = planned_for(**policy, situation, clock);
  if (!plan) return plan.error();
  return answer_json(known, app, *plan, costs->unknown);
}

}  // namespace ctn::tool
