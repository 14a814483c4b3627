#include "plan/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plan/batches.h"
#include "plan/check.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::plan {
namespace {

constexpr double kNearZero = 1e-12;
constexpr const char* kPlanAgain = "make the plan again, for this app, these costs and these cores";

}  // namespace

bool same(double a, double b) { return std::abs(a - b) <= kTolerance * std::max(std::abs(a), std::abs(b)) + kNearZero; }

void Check::problem(std::string key, std::string what) {
  problems_.push_back({{}, std::move(key), std::move(what), kPlanAgain});
}

void Check::expect(const std::string& key, double planned, double must_be, const char* why) {
  if (!same(planned, must_be)) problem(key, fmt::format("{} is planned, but {} gives {}", planned, why, must_be));
}

std::string Check::subchain_key(SubchainId id, const char* field) const {
  return fmt::format("subchains.{}.{}", app.graph.subchain(id).name, field);
}

std::string Check::core_key(std::size_t core, const char* field) { return fmt::format("cores[{}].{}", core, field); }

std::string Check::slot_key(std::size_t core, std::size_t slot, const char* field) {
  return fmt::format("cores[{}].slots[{}].{}", core, slot, field);
}

std::string Check::member_key(std::size_t core, std::size_t member, const char* field) {
  return fmt::format("cores[{}].members[{}].{}", core, member, field);
}

Status validate_layout(const Plan& plan, const graph::App& app, int core_count) {
  const model::CostTable unknown(app.graph, Millis{0});
  const graph::App planned = as_planned(app, plan);
  Check check(plan, planned, unknown);
  check_shape(check, core_count);
  if (check.ok()) check_cores(check);
  if (check.ok()) {
    check_frames(check);
    check_members(check);
    check_rates(check);
  }
  if (!check.ok()) return Error(ErrorKind::kCaller, check.take_problems());
  return Done{};
}

Status validate(const Plan& plan, const graph::App& app, const model::CostTable& costs, int core_count) {
  const graph::App planned = as_planned(app, plan);
  const model::CostTable of_runs = at_batches(costs, plan.batches, app.graph);
  Check check(plan, planned, of_runs);
  check_shape(check, core_count);
  if (check.ok()) check_cores(check);
  if (check.ok()) {
    check_frames(check);
    if (check_members(check)) check_groups(check);
    check_rates(check);
    check_promises(check);
  }
  if (check.ok()) check_batches(check, costs);
  if (!check.ok()) return Error(ErrorKind::kCaller, check.take_problems());
  return Done{};
}

}  // namespace ctn::plan
