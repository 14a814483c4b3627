// Stage I: core allocation as if all that share a core took equal shares of it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "planner/allocation.h"
#include "planner/pieces.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// With equal shares among so many, itself included; infinite where that is too long for an exact rate.
double period_among(const Instance& instance, std::size_t i, int kind, int rivals) {
  const Member& member = instance.members[i];
  const double period = std::max(rivals * member.on_kind(kind).cost / instance.usable, member.min_period);
  if (member.exact_period <= 0.0) return period;
  return period <= member.exact_period * (1.0 + kProven) ? member.exact_period : kInfinity;
}

}  // namespace

std::vector<Timing> equal_shares(const Instance& instance, const Allocation& allocation) {
  std::vector<int> sharing(static_cast<std::size_t>(allocation.shared_cores), 0);
  for (const int core : allocation.core_of) {
    if (core >= 0) ++sharing[static_cast<std::size_t>(core)];
  }
  std::vector<Timing> timings;
  for (std::size_t i = 0; i < instance.members.size(); ++i) {
    const Member& member = instance.members[i];
    if (allocation.core_of[i] < 0) {
      const Owned& owned = member.on_kind(allocation.kind[i]).owned[static_cast<std::size_t>(allocation.owned[i] - 1)];
      timings.push_back({owned.period, owned.execution});
      continue;
    }
    const int rivals = sharing[static_cast<std::size_t>(allocation.core_of[i])];
    const double period = period_among(instance, i, allocation.kind[i], rivals);
    timings.push_back({period, period});
  }
  return timings;
}

namespace {

// With equal shares only the *sizes* of the groups matter: subchain i has k cores of its own, or is one of m on a core
// of some kind.
// So the search chooses a class for each subchain, not a partner; those of a class are then put together in their
// order.
class StageOne {
 public:
  StageOne(const Instance& instance, const Target& target, Effort& effort)
      : instance_(instance), target_(target), effort_(effort) {
    const std::size_t count = instance.members.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<Choice>& choices = choices_.emplace_back();
      for (int kind = 0; kind < instance.kind_count(); ++kind) {
        const std::vector<Owned>& owned = instance.members[i].on_kind(kind).owned;
        for (int k = 1; k <= static_cast<int>(owned.size()); ++k) {
          const Owned& alone = owned[static_cast<std::size_t>(k - 1)];
          if (std::isfinite(alone.period)) choices.push_back({{alone.period, alone.execution}, k, 1, kind});
        }
        for (int m = 2; m <= static_cast<int>(count); ++m) {
          const double period = period_among(instance, i, kind, m);
          if (std::isfinite(period)) choices.push_back({{period, period}, 1, m, kind});
        }
      }
      std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
        return a.timing.period + a.timing.execution < b.timing.period + b.timing.execution;
      });
    }
    step_ = 1 + (count - 1) / kCheap;
    chosen_.assign(count, 0);
    in_class_.assign(instance.kinds.size(), std::vector<int>(count + 1, 0));
    owned_.assign(instance.kinds.size(), 0);
    timings_.resize(count);
  }

  Planned run() {
    Planned planned;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      if (choices_[i].empty()) return planned;
      timings_[i] = shortest(i);
    }
    descend(0);
    planned.found = std::isfinite(best_);
    if (planned.found) planned.allocation = built();
    // The search may end before it comes to any allocation, or to a good one.
    if (effort_.left == 0 && (!planned.found || choices_.size() > kCheap)) deal(planned);
    if (!planned.found) return planned;
    planned.shares.value = best_;
    planned.bound = effort_.left > 0 ? best_ : 0.0;
    return planned;
  }

 private:
  struct Choice {
    Timing timing;
    int cores = 1;
    int rivals = 1;  // how many share the core, itself included
    int kind = 0;
  };

  Timing shortest(std::size_t i) const {
    Timing timing{kInfinity, kInfinity};
    for (const Choice& choice : choices_[i]) {
      timing.period = std::min(timing.period, choice.timing.period);
      timing.execution = std::min(timing.execution, choice.timing.execution);
    }
    return timing;
  }

  double value() const { return weighted_sum(target_.groups, timings_); }

  bool limits_hold() const {
    return std::all_of(target_.limits.begin(), target_.limits.end(),
                       [&](const Group& limit) { return value_of(limit, timings_) <= limit.limit * (1.0 + kProven); });
  }

  // There are cores for all that the classes begun need, each of them full.
  bool cores_suffice() const {
    for (std::size_t kind = 0; kind < in_class_.size(); ++kind) {
      int cores = owned_[kind];
      for (std::size_t m = 2; m < in_class_[kind].size(); ++m) {
        cores += static_cast<int>((static_cast<std::size_t>(in_class_[kind][m]) + m - 1) / m);
      }
      if (cores > instance_.kinds[kind].count) return false;
    }
    return true;
  }
  // Subchains that are still missing for all classes begun to be full.
  std::size_t missing() const {
    std::size_t sum = 0;
    for (const std::vector<int>& of_kind : in_class_) {
      for (std::size_t m = 2; m < of_kind.size(); ++m) sum += (m - static_cast<std::size_t>(of_kind[m]) % m) % m;
    }
    return sum;
  }

  // Counts a choice in, or out again.
  void count(const Choice& choice, int sign) {
    const auto kind = static_cast<std::size_t>(choice.kind);
    if (choice.rivals > 1) {
      in_class_[kind][static_cast<std::size_t>(choice.rivals)] += sign;
    } else {
      owned_[kind] += sign * choice.cores;
    }
  }

  void descend(std::size_t i) {
    if (effort_.left == 0) return;
    if (i == choices_.size()) {
      if (missing() > 0 || !limits_hold()) return;
      const double found = value();
      if (found < best_) {
        best_ = found;
        best_choice_ = chosen_;
      }
      return;
    }
    const Timing before = timings_[i];
    for (std::size_t c = 0; c < choices_[i].size(); ++c) {
      const Choice& choice = choices_[i][c];
      count(choice, 1);
      timings_[i] = choice.timing;
      chosen_[i] = c;
      effort_.spend(step_);
      if (cores_suffice() && missing() <= choices_.size() - i - 1 && value() * (1.0 + kProven) < best_ &&
          limits_hold()) {
        descend(i + 1);
      }
      count(choice, -1);
    }
    timings_[i] = before;
  }

  // Equally many to each core, in their order, if that is better.
  void deal(Planned& planned) {
    const std::size_t count = choices_.size();
    const std::size_t cores = std::min(count, static_cast<std::size_t>(instance_.cores()));
    std::vector<Piece> pieces(cores);
    std::size_t core = 0;
    for (int kind = 0; kind < instance_.kind_count(); ++kind) {
      for (int k = 0; k < instance_.kind(kind).count && core < cores; ++k) pieces[core++].kind = kind;
    }
    for (std::size_t i = 0; i < count; ++i) pieces[i * cores / count].set |= Set::of(i);
    const Allocation allocation = to_allocation(pieces, count);
    timings_ = equal_shares(instance_, allocation);
    const double found = value();
    if (!(found < best_) || !limits_hold()) return;
    best_ = found;
    planned.found = true;
    planned.allocation = allocation;
  }

  Allocation built() const {
    Allocation allocation = Allocation::none(choices_.size());
    std::map<std::pair<int, int>, std::pair<int, int>> open;  // kind and class: core, and how many it has
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const Choice& choice = choices_[i][best_choice_[i]];
      if (choice.rivals == 1) {
        allocation.own(i, choice.cores, choice.kind);
        continue;
      }
      const std::pair<int, int> full{-1, choice.rivals};
      auto& [core, members] = open.try_emplace({choice.kind, choice.rivals}, full).first->second;
      if (members == choice.rivals) {
        core = allocation.shared_cores++;
        members = 0;
      }
      allocation.core_of[i] = core;
      allocation.kind[i] = choice.kind;
      ++members;
    }
    return allocation;
  }

  const Instance& instance_;
  const Target& target_;
  Effort& effort_;
  std::vector<std::vector<Choice>> choices_;
  std::vector<std::size_t> chosen_;
  std::vector<std::size_t> best_choice_;
  std::vector<std::vector<int>> in_class_;  // by kind and m
  std::vector<int> owned_;                  // by kind: cores
  std::vector<Timing> timings_;
  double best_ = kInfinity;
  std::size_t step_ = 1;  // what a look at a choice costs
};

}  // namespace

Planned allocate_by_equal_shares(const Instance& instance, const Target& target, Effort& effort) {
  return StageOne(instance, target, effort).run();
}

}  // namespace ctn::planner
