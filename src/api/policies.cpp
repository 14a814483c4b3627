#include "api/policies.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "api/known_costs.h"
#include "baselines/policies.h"
#include "config/app_file.h"
#include "plan/json.h"
#include "policy/hand_set.h"
#include "policy/planned.h"

namespace ctn::api {
namespace {

constexpr std::string_view kStatic = "static";
constexpr std::string_view kRatesOf = "rates-of";

// "NAME" or "NAME:FILE".
struct Parts {
  std::string name;
  std::optional<std::string> file;  // not empty
};

std::optional<Parts> parts_of(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return Parts{std::string(text), {}};
  if (colon + 1 == text.size()) return std::nullopt;
  return Parts{std::string(text.substr(0, colon)), std::string(text.substr(colon + 1))};
}

Result<SimulatedPolicy> by_plan_of(const Parts& parts, std::string_view name, const graph::App& app) {
  const Result<std::string> text = config::read_text(*parts.file);
  if (!text) return text.error();
  Result<plan::Plan> plan = plan::from_json(*text, app, *parts.file);
  if (!plan) return plan.error();
  if (parts.name == kRatesOf) {
    return SimulatedPolicy{std::make_shared<policy::PlannedRatesPolicy>(std::string(name), std::move(*plan))};
  }
  return SimulatedPolicy{std::make_shared<policy::StaticPolicy>(std::string(name), std::move(*plan))};
}

Result<SimulatedPolicy> baseline(const Parts& parts, std::string_view name, const graph::App& app) {
  baselines::GivenCosts given;
  if (parts.file) {
    Result<KnownCosts> known = known_costs(*parts.file, app);
    if (!known) return known.error();
    given = std::move(known->costs);
  }
  baselines::Baseline made = baselines::make_baseline(parts.name, std::string(name), std::move(given));
  return SimulatedPolicy{std::move(made.policy), std::move(made.reserve)};
}

}  // namespace

Result<SimulatedPolicy> simulated_policy(std::string_view name, const graph::App& app) {
  if (const std::optional<Parts> parts = parts_of(name)) {
    if ((parts->name == kStatic || parts->name == kRatesOf) && parts->file) return by_plan_of(*parts, name, app);
    if (baselines::is_baseline(parts->name)) return baseline(*parts, name, app);
  }
  const bool by_paper = name == "catan" && app.scheduler.planner == graph::PlannerKind::kPaper;
  if (auto own = policy::make_policy(by_paper ? "paper" : name)) return SimulatedPolicy{std::move(*own)};
  return Error::caller(
      fmt::format("'{}' is no scheduler", name),
      "write catan, auto, paper, default, fifo, static:PLAN.json, rates-of:PLAN.json, a source rate as "
      "in rate:12.5, or picas, deadline, davare or verucchi, with compute times as in "
      "picas:COSTS.yaml");
}

Result<std::shared_ptr<const policy::Policy>> live_policy(std::string_view name, const graph::App& app) {
  Result<SimulatedPolicy> made = simulated_policy(name, app);
  if (!made) return made.error();
  if (made->reserve) {
    return Error::caller(fmt::format("scheduler '{}' reserves CPU time, which only the simulator can do", name),
                         "use catan sim, or another scheduler");
  }
  if (made->policy->needs_costs()) return policy::costs_missing(*made->policy);
  return std::move(made->policy);
}

}  // namespace ctn::api
