// One entry a subchain and core, numbers that are numbers, indexes that index: what the other checks take for granted.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plan/check.h"
#include "plan/predict.h"

namespace ctn::plan {
namespace {

void check_number(Check& check, const std::string& key, double number) {
  if (!std::isfinite(number) || number < 0.0) check.problem(key, fmt::format("{} is no number from 0 up", number));
}

void check_number(Check& check, const std::string& key, Millis duration) { check_number(check, key, duration.count()); }

void check_every(Check& check, const std::string& key, const std::optional<int>& every) {
  if (every && *every < 1) check.problem(key, fmt::format("{} is no number of frames", *every));
}

void check_subchain(Check& check, SubchainId id, int core_count) {
  const SubchainPlan& subchain = check.plan.subchains[id.index()];
  check_number(check, check.subchain_key(id, "period_ms"), subchain.period);
  check_number(check, check.subchain_key(id, "execution_ms"), subchain.execution);
  check_number(check, check.subchain_key(id, "wait_ms"), subchain.wait);
  check_number(check, check.subchain_key(id, "slice_ms"), subchain.slice);
  check_number(check, check.subchain_key(id, "share"), subchain.share);
  check_every(check, check.subchain_key(id, "every"), subchain.every);
  if (subchain.share == 0.0) check.problem(check.subchain_key(id, "share"), "a share of 0 never runs");
  if (subchain.threads < 1) {
    check.problem(check.subchain_key(id, "threads"), fmt::format("{} is no number of threads", subchain.threads));
  }
  const std::string key = check.subchain_key(id, "cores");
  if (subchain.cores.empty()) check.problem(key, "the subchain has no core");
  if (std::adjacent_find(subchain.cores.begin(), subchain.cores.end(), std::greater_equal<>()) !=
      subchain.cores.end()) {
    check.problem(key, "cores are named twice or not in ascending order");
  }
  for (const int core : subchain.cores) {
    if (core < 0 || core >= core_count) {
      check.problem(key, fmt::format("there is no core {} among {}", core, core_count));
    }
  }
}

void check_member(Check& check, std::size_t number, std::size_t index) {
  const Member& member = check.plan.cores[number].members[index];
  const auto key = [&](const char* field) { return Check::member_key(number, index, field); };
  check_number(check, key("period_ms"), member.period);
  check_number(check, key("phase_ms"), member.phase);
  check_number(check, key("budget_ms"), member.budget);
  if (member.pause) check_number(check, key("pause_ms"), *member.pause);
  const std::size_t subchains = check.app.graph.subchains().size();
  if (member.subchain.index() >= subchains) check.problem(key("subchain"), "the app has no such subchain");
  if (member.clock &&
      (member.clock->index() >= check.app.graph.nodes().size() || !check.app.graph.node(*member.clock).has_clock())) {
    check.problem(key("clock"), "the app has no node with such a clock");
  }
  if (!member.after) return;
  const SubchainId* const leader = member.after->subchain();
  if (leader != nullptr && leader->index() >= subchains) {
    check.problem(key("after.subchain"), "the app has no such subchain");
  }
  if (const NodeId* const node = member.after->node()) {
    const bool known = node->index() < check.app.graph.nodes().size();
    if (!known || !check.app.graph.node(*node).unscheduled) {
      check.problem(key("after.node"), "the app has no such unscheduled node");
    }
  }
  if (member.after->every < 1) {
    check.problem(key("after.every"), fmt::format("{} is no number of outputs", member.after->every));
  }
}

void check_core(Check& check, std::size_t number) {
  const CorePlan& core = check.plan.cores[number];
  check_number(check, Check::core_key(number, "frame_ms"), core.frame);
  check_number(check, Check::core_key(number, "frame_min_ms"), core.frame_min);
  check_number(check, Check::core_key(number, "idle_ms"), core.idle);
  for (std::size_t i = 0; i < core.members.size(); ++i) check_member(check, number, i);
  for (std::size_t i = 0; i < core.slots.size(); ++i) {
    const Slot& slot = core.slots[i];
    check_number(check, Check::slot_key(number, i, "offset_ms"), slot.offset);
    check_number(check, Check::slot_key(number, i, "slice_ms"), slot.slice);
    check_every(check, Check::slot_key(number, i, "every"), slot.every);
    if (slot.subchain.index() >= check.app.graph.subchains().size()) {
      check.problem(Check::slot_key(number, i, "subchain"), "the app has no such subchain");
    }
    if (slot.phase < 0 || slot.phase >= slot.every.value_or(1)) {
      check.problem(Check::slot_key(number, i, "phase"),
                    fmt::format("phase {} is not among frames 0 to {}", slot.phase, slot.every.value_or(1) - 1));
    }
  }
}

void check_header(Check& check) {
  const Plan& plan = check.plan;
  check_number(check, "gap", plan.gap);
  check_number(check, "solve_ms", plan.solve_time);
  check_number(check, "objective", plan.objective);
  check_number(check, "relaxed.factor", plan.relax_factor);
  if (plan.planner.empty()) check.problem("planner", "who made the plan is not named");
  if (!(plan.slack >= 0.0 && plan.slack < 1.0)) {
    check.problem("slack", fmt::format("{} is no share of a core from 0 to below 1", plan.slack));
  }
  if (plan.quality == Quality::kOptimal && plan.gap > kTolerance) {
    check.problem("gap", fmt::format("a plan with a gap of {} is not proven to be optimal", plan.gap));
  }
}

}  // namespace

void check_shape(Check& check, int core_count) {
  const Plan& plan = check.plan;
  check_header(check);
  for (std::size_t i = 0; i < plan.batches.size(); ++i) {
    const bool known = plan.batches[i].node.index() < check.app.graph.nodes().size();
    if (!known) check.problem(fmt::format("batches[{}].node", i), "the app has no such node");
    if (plan.batches[i].items < 0) {
      check.problem(fmt::format("batches[{}].items", i),
                    fmt::format("{} is no number of items", plan.batches[i].items));
    }
  }
  const std::size_t subchains = check.app.graph.subchains().size();
  if (plan.subchains.size() != subchains) {
    check.problem("subchains", fmt::format("{} are planned, the app has {}", plan.subchains.size(), subchains));
  } else {
    for (std::size_t i = 0; i < subchains; ++i) check_subchain(check, SubchainId{i}, core_count);
  }
  if (core_count > check.app.core_count().value_or(core_count)) {
    check.problem("cores", fmt::format("there are {}, the app lists {}", core_count, *check.app.core_count()));
  }
  if (plan.cores.size() != static_cast<std::size_t>(core_count)) {
    check.problem("cores", fmt::format("{} are planned, there are {}", plan.cores.size(), core_count));
  }
  for (std::size_t i = 0; i < plan.cores.size(); ++i) check_core(check, i);
}

}  // namespace ctn::plan
