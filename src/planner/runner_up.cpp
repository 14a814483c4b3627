#include "planner/runner_up.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "plan/predict.h"
#include "planner/allocation.h"
#include "planner/assemble.h"
#include "planner/instance.h"
#include "planner/pieces.h"

namespace ctn::planner {
namespace {

using Groups = std::vector<CoreGroup>;

constexpr std::size_t kFewSubchains = 7;  // up to here all allocations are looked at
constexpr std::size_t kMostAllocations = 20'000;
constexpr std::size_t kEfforts = 4;  // of what a plan may take, for all allocations together

int cores_of(const Groups& groups, int kind) {
  return std::accumulate(groups.begin(), groups.end(), 0,
                         [&](int sum, const CoreGroup& group) { return sum + (group.kind == kind ? group.cores : 0); });
}

bool any_shared(const Groups& groups, int kind) {
  return std::any_of(groups.begin(), groups.end(),
                     [&](const CoreGroup& group) { return group.kind == kind && group.subchains.size() > 1; });
}

// Numbers of cores of a kind that make a subchain faster than any fewer do, by subchain, ascending.
std::vector<std::vector<int>> cores_of_use(const Instance& instance, int kind) {
  std::vector<std::vector<int>> useful;
  for (const Member& member : instance.members) {
    std::vector<int>& counts = useful.emplace_back();
    Owned best{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 1};
    for (std::size_t k = 0; k < member.on_kind(kind).owned.size(); ++k) {
      const Owned& owned = member.on_kind(kind).owned[k];
      if (!(owned.period < best.period || owned.execution < best.execution)) continue;
      best.period = std::min(best.period, owned.period);
      best.execution = std::min(best.execution, owned.execution);
      counts.push_back(static_cast<int>(k + 1));
    }
  }
  return useful;
}

Allocation to_allocation(const Groups& groups, std::size_t subchains) {
  std::vector<Piece> pieces;
  for (const CoreGroup& group : groups) {
    Piece& piece = pieces.emplace_back(Piece{{}, group.cores, group.kind});
    for (const SubchainId id : group.subchains) piece.set |= Set::of(id.index());
  }
  return planner::to_allocation(pieces, subchains);
}

// A set of allocations without the plan's own.
class Others {
 public:
  Others(const Instance& instance, Groups own) : instance_(instance), own_(std::move(own)) {
    for (int kind = 0; kind < instance.kind_count(); ++kind) useful_.push_back(cores_of_use(instance, kind));
  }

  // False: there are too many.
  bool add_all() {
    Groups groups;
    return partition(0, groups);
  }

  void add_neighbours() {
    for (std::size_t from = 0; from < own_.size(); ++from) {
      for (const SubchainId id : own_[from].subchains) {
        for (std::size_t to = 0; to < own_.size(); ++to) {
          if (to == from) continue;
          complete(moved(id, from, to));
          for (const SubchainId other : own_[to].subchains) {
            if (from < to) complete(swapped(id, from, other, to));
          }
        }
        if (own_[from].subchains.size() > 1) set_apart(id, from);
      }
    }
    for (std::size_t from = 0; from < own_.size(); ++from) {
      for (std::size_t to = 0; to < own_.size(); ++to) {
        hand_over(from, to);
        exchange_kinds(from, to);
      }
      for (int kind = 0; kind < instance_.kind_count(); ++kind) change_kind(from, kind);
    }
  }

  const std::set<Groups>& found() const { return found_; }

 private:
  bool partition(std::size_t i, Groups& groups) {
    if (i == instance_.members.size()) return own(0, groups);
    // By value: deeper levels add groups and take them away again.
    for (std::size_t g = 0, count = groups.size(); g < count; ++g) {
      groups[g].subchains.emplace_back(i);
      const bool room = partition(i + 1, groups);
      groups[g].subchains.pop_back();
      if (!room) return false;
    }
    bool room = true;
    for (int kind = 0; kind < instance_.kind_count() && room; ++kind) {
      if (spare(groups, kind) <= 0) continue;
      groups.push_back({{SubchainId(i)}, 1, kind});
      room = partition(i + 1, groups);
      groups.pop_back();
    }
    return room;
  }

  int spare(const Groups& groups, int kind) const { return instance_.kind(kind).count - cores_of(groups, kind); }
  bool too_many(const Groups& groups) const {
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      if (spare(groups, kind) < 0) return true;
    }
    return false;
  }
  // How many cores of its kind are of use to one that is alone.
  const std::vector<int>& useful(const CoreGroup& alone) const {
    return useful_[static_cast<std::size_t>(alone.kind)][alone.subchains.front().index()];
  }

  // Gives those that are alone cores, in every way.
  bool own(std::size_t g, Groups& groups) {
    if (too_many(groups)) return true;
    if (g == groups.size()) {
      add(groups);
      return found_.size() < kMostAllocations;
    }
    if (groups[g].subchains.size() > 1) return own(g + 1, groups);
    bool room = true;
    for (const int cores : useful(groups[g])) {
      groups[g].cores = cores;
      if (room) room = own(g + 1, groups);
    }
    groups[g].cores = 1;
    return room;
  }

  // No core may be left without work beside a shared one of its kind.
  void add(Groups groups) {
    if (too_many(groups)) return;
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      if (spare(groups, kind) > 0 && any_shared(groups, kind)) return;
    }
    std::sort(groups.begin(), groups.end());
    if (groups != own_) found_.insert(std::move(groups));
  }

  static void take(Groups& groups, SubchainId id, std::size_t from) { std::erase(groups[from].subchains, id); }
  static void put(Groups& groups, SubchainId id, std::size_t to) {
    std::vector<SubchainId>& members = groups[to].subchains;
    members.insert(std::upper_bound(members.begin(), members.end(), id), id);
    if (members.size() > 1) groups[to].cores = 1;
  }

  Groups moved(SubchainId id, std::size_t from, std::size_t to) const {
    Groups groups = own_;
    take(groups, id, from);
    put(groups, id, to);
    return groups;
  }

  Groups swapped(SubchainId a, std::size_t of_a, SubchainId b, std::size_t of_b) const {
    Groups groups = own_;
    take(groups, a, of_a);
    take(groups, b, of_b);
    put(groups, a, of_b);
    put(groups, b, of_a);
    return groups;
  }

  // On a core of its own: a spare one, or one of an owner's several.
  void set_apart(SubchainId id, std::size_t from) {
    Groups groups = own_;
    take(groups, id, from);
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      groups.push_back({{id}, 1, kind});
      complete(groups);
      for (CoreGroup& group : groups) {
        if (group.cores == 1 || group.kind != kind) continue;
        --group.cores;
        complete(groups);
        ++group.cores;
      }
      groups.pop_back();
    }
  }

  // All that share a core, or one that is alone on one, on a core of another kind.
  void change_kind(std::size_t from, int kind) {
    if (own_[from].kind == kind || own_[from].cores > 1) return;
    Groups groups = own_;
    groups[from].kind = kind;
    complete(std::move(groups));
  }

  void exchange_kinds(std::size_t from, std::size_t to) {
    if (from >= to || own_[from].kind == own_[to].kind || own_[from].cores != own_[to].cores) return;
    Groups groups = own_;
    std::swap(groups[from].kind, groups[to].kind);
    complete(std::move(groups));
  }

  void hand_over(std::size_t from, std::size_t to) {
    if (from == to || own_[from].kind != own_[to].kind) return;
    if (own_[from].cores == 1 || own_[to].subchains.size() > 1) return;
    Groups groups = own_;
    --groups[from].cores;
    ++groups[to].cores;
    complete(std::move(groups));
  }

  // Cores left over go to those that are alone: as many as are of use to one of them, the rest to the next.
  void complete(Groups groups) {
    std::erase_if(groups, [](const CoreGroup& group) { return group.subchains.empty(); });
    for (const CoreGroup& group : groups) {
      if (group.subchains.size() > 1) continue;
      const std::vector<int>& of_use = useful(group);
      if (std::find(of_use.begin(), of_use.end(), group.cores) == of_use.end()) return;
    }
    add(groups);
    for (std::size_t first = 0; first < groups.size(); ++first) {
      Groups filled = groups;
      for (std::size_t step = 0; step < filled.size(); ++step) {
        CoreGroup& group = filled[(first + step) % filled.size()];
        give(group, spare(filled, group.kind));
      }
      add(std::move(filled));
    }
  }

  void give(CoreGroup& group, int spare) const {
    if (group.subchains.size() > 1) return;
    const int before = group.cores;
    for (const int cores : useful(group)) {
      if (cores <= before + spare) group.cores = std::max(group.cores, cores);
    }
  }

  const Instance& instance_;
  std::vector<std::vector<std::vector<int>>> useful_;  // by kind and subchain
  const Groups own_;
  std::set<Groups> found_;
};

class Contest {
 public:
  Contest(const Instance& instance, const std::set<Groups>& all, std::size_t effort)
      : instance_(instance), effort_{effort} {
    for (const Groups& groups : all) allocations_.push_back(to_allocation(groups, instance.members.size()));
    sort_by_promise();
  }

  // With a relax factor of `factor` if that can be had, else with the least that can.
  Planned run(double factor) {
    Planned best = best_under(objective_target(instance_, factor * kAbove));
    if (best.found) return best;
    best = best_under(factor_target(instance_));
    if (!best.found) return best;
    const double least = std::max(1.0, best.shares.value);
    Planned under = best_under(objective_target(instance_, least * kAbove));
    return under.found ? under : best;
  }

  bool to_the_end() const { return effort_.left > 0; }

 private:
  static constexpr double kAbove = 1.0 + plan::kTolerance / 100.0;  // for rounding

  // Good ones first, so that most others are cut off early.
  void sort_by_promise() {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < allocations_.size(); ++i) {
      order.emplace_back(objective_of(instance_, equal_shares(instance_, allocations_[i])), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<Allocation> sorted;
    for (const auto& [promise, i] : order) sorted.push_back(std::move(allocations_[i]));
    allocations_ = std::move(sorted);
  }

  Planned best_under(const Target& target) {
    Planned best;
    SharesSolver solver(instance_, target);
    for (const Allocation& allocation : allocations_) {
      if (effort_.left == 0) break;
      Shares shares = solver.solve(allocation, best.shares.value, effort_);
      if (!shares.found || !(shares.value < best.shares.value)) continue;
      best.found = true;
      best.allocation = allocation;
      best.shares = std::move(shares);
    }
    return best;
  }

  const Instance& instance_;
  Effort effort_;
  std::vector<Allocation> allocations_;
};

}  // namespace

RunnerUp runner_up_of(const graph::App& app, const model::CostTable& costs, const Request& request,
                      const plan::Plan& plan) {
  const Instance instance = make_instance(app, costs, request.cores, request.slack);
  Others others(instance, allocation_groups(plan, app));
  const bool all = instance.members.size() <= kFewSubchains && others.add_all();
  if (!all) others.add_neighbours();
  RunnerUp runner_up;
  runner_up.allocations = others.found().size();
  Contest contest(instance, others.found(), kEfforts * request.effort);
  const Planned planned = contest.run(plan.relax_factor);
  runner_up.proven = all && contest.to_the_end();
  if (planned.found) {
    runner_up.plan = assemble(app, costs, instance, planned, request.cores, request.slack);
    runner_up.plan->planner = plan.planner;
  }
  return runner_up;
}

}  // namespace ctn::planner
