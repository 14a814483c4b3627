#include "planner/assemble.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "model/formulas.h"
#include "plan/limits.h"
#include "plan/predict.h"

namespace ctn::planner {
namespace {

std::vector<int> numbers_from(int first, int count) {
  std::vector<int> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

// Of each kind the next core that nobody has.
class Numbers {
 public:
  explicit Numbers(const Instance& instance) {
    for (const CoreKind& kind : instance.kinds) next_.push_back(kind.first);
  }
  int take(int kind, int count = 1) { return std::exchange(of(kind), of(kind) + count); }

 private:
  int& of(int kind) { return next_[static_cast<std::size_t>(kind)]; }
  std::vector<int> next_;
};

void place(const Instance& instance, const Allocation& allocation, plan::Plan& plan,
           std::vector<int>& number_of_shared) {
  Numbers numbers(instance);
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const int shared = allocation.core_of[i];
    if (shared < 0) {
      plan.subchains[i].cores =
          numbers_from(numbers.take(allocation.kind[i], allocation.owned[i]), allocation.owned[i]);
      continue;
    }
    int& number = number_of_shared[static_cast<std::size_t>(shared)];
    if (number < 0) number = numbers.take(allocation.kind[i]);
    plan.subchains[i].cores = {number};
  }
}

void own(const Member& member, const OnKind& on, int cores, plan::SubchainPlan& subchain) {
  const Owned& owned = on.owned[static_cast<std::size_t>(cores - 1)];
  subchain.period = Millis{owned.promised};
  subchain.execution = Millis{owned.execution + member.wait};
  subchain.wait = Millis{member.wait};
  subchain.slice = Millis{on.cost};
  subchain.threads = owned.threads;
  if (!member.queue) subchain.every = 1;
}

void share(const Member& member, const OnKind& on, double frame, double period, plan::SubchainPlan& subchain) {
  double f = frame / period;
  if (!member.queue) {
    subchain.every = std::max(1, static_cast<int>(std::lround(period / frame)));
    f = 1.0 / *subchain.every;
  }
  subchain.share = f;
  subchain.slice = Millis{f * on.cost};
  subchain.wait = Millis{member.wait};
  const model::SharedTiming timing =
      model::shared_core({Millis{frame}, f, subchain.slice, subchain.wait}, member.exact_period > 0.0);
  subchain.period = timing.period;
  subchain.execution = timing.execution;
}

void lay_out(const graph::App& app, const Instance& instance, const Allocation& allocation, int shared, double frame,
             double slack, plan::Plan& plan, plan::CorePlan& core) {
  Millis offset{0};
  core.frames = app.scheduler.frames;
  for (const SubchainId id : app.order) {
    if (allocation.core_of[id.index()] != shared) continue;
    plan::SubchainPlan& subchain = plan.subchains[id.index()];
    core.slots.push_back({id, offset, subchain.slice, subchain.every, 0});
    offset += subchain.slice;
    const Member& member = instance.members[id.index()];
    core.frame_min =
        std::max(core.frame_min, Millis{subchain.share * std::max(member.min_period, member.exact_period)});
    if (member.exact_period > 0.0) core.frames = graph::FrameMode::kFixed;
  }
  core.idle = std::max(Millis{0}, Millis{frame} * (1.0 - slack) - offset);
  core.frame = (offset + core.idle) / (1.0 - slack);
  core.frame_min = std::min(core.frame_min, core.frame);
}

}  // namespace

plan::Plan assemble(const graph::App& app, const model::CostTable& costs, const Instance& instance,
                    const Planned& planned, int cores, double slack) {
  const Allocation& allocation = planned.allocation;
  plan::Plan plan;
  plan.slack = slack;
  plan.subchains.resize(instance.members.size());
  plan.cores.resize(static_cast<std::size_t>(cores));
  std::vector<int> number_of_shared(static_cast<std::size_t>(allocation.shared_cores), -1);
  place(instance, allocation, plan, number_of_shared);
  for (plan::CorePlan& core : plan.cores) core.frames = app.scheduler.frames;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const Member& member = instance.members[i];
    const int shared = allocation.core_of[i];
    if (shared < 0) {
      own(member, member.on_kind(allocation.kind[i]), allocation.owned[i], plan.subchains[i]);
    } else {
      share(member, member.on_kind(allocation.kind[i]), planned.shares.frames[static_cast<std::size_t>(shared)],
            planned.shares.timings[i].period, plan.subchains[i]);
    }
  }
  for (int shared = 0; shared < allocation.shared_cores; ++shared) {
    const auto s = static_cast<std::size_t>(shared);
    lay_out(app, instance, allocation, shared, planned.shares.frames[s], slack, plan,
            plan.cores[static_cast<std::size_t>(number_of_shared[s])]);
  }
  plan::fill_predictions(plan, app, costs);
  return plan;
}

bool allocation_of(const plan::Plan& plan, const Instance& instance, Allocation& allocation) {
  const std::size_t count = instance.members.size();
  if (plan.subchains.size() != count) return false;
  std::vector<int> members(plan.cores.size(), 0);
  for (const plan::SubchainPlan& subchain : plan.subchains) {
    if (subchain.cores.empty()) return false;
    for (const int core : subchain.cores) {
      if (core < 0 || core >= static_cast<int>(members.size())) return false;
      ++members[static_cast<std::size_t>(core)];
    }
  }
  allocation = Allocation::none(count);
  std::vector<int> used(instance.kinds.size(), 0);
  const auto use = [&](int kind, int cores) { used[static_cast<std::size_t>(kind)] += cores; };
  std::vector<int> number(members.size(), -1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<int>& cores = plan.subchains[i].cores;
    const auto first = static_cast<std::size_t>(cores.front());
    const int kind = instance.kind_of_core(cores.front());
    if (cores.size() == 1 && members[first] > 1) {
      if (number[first] < 0) {
        number[first] = allocation.shared_cores++;
        use(kind, 1);
      }
      allocation.core_of[i] = number[first];
      allocation.kind[i] = kind;
    } else {
      for (const int core : cores) {
        if (members[static_cast<std::size_t>(core)] > 1 || instance.kind_of_core(core) != kind) return false;
      }
      const std::vector<Owned>& owned = instance.members[i].on_kind(kind).owned;
      if (cores.size() > owned.size() || !std::isfinite(owned[cores.size() - 1].period)) return false;
      allocation.own(i, static_cast<int>(cores.size()), kind);
      use(kind, allocation.owned[i]);
    }
  }
  for (int kind = 0; kind < instance.kind_count(); ++kind) {
    if (used[static_cast<std::size_t>(kind)] > instance.kind(kind).count) return false;
  }
  return true;
}

}  // namespace ctn::planner
