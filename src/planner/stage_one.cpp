// Stage I: core allocation as if all that share a core took equal shares of it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "planner/allocation.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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
      const Owned& owned = member.owned[static_cast<std::size_t>(allocation.owned[i] - 1)];
      timings.push_back({owned.period, owned.execution});
      continue;
    }
    const int rivals = sharing[static_cast<std::size_t>(allocation.core_of[i])];
    double period = std::max(rivals * member.cost / instance.usable, member.least_period);
    if (member.exact_period > 0.0) {
      period = period <= member.exact_period * (1.0 + kProven) ? member.exact_period : kInfinity;
    }
    timings.push_back({period, period});
  }
  return timings;
}

namespace {

// With equal shares only the *sizes* of the groups matter: subchain i has k cores of its own, or is one of m on a core.
// So the search chooses a class for each subchain, not a partner; those of a class are then put together in their
// order.
class StageOne {
 public:
  StageOne(const Instance& instance, const Target& target, Effort& effort)
      : instance_(instance), target_(target), effort_(effort) {
    const std::size_t count = instance.members.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Member& member = instance.members[i];
      std::vector<Choice>& choices = choices_.emplace_back();
      for (int k = 1; k <= static_cast<int>(member.owned.size()); ++k) {
        const Owned& owned = member.owned[static_cast<std::size_t>(k - 1)];
        if (std::isfinite(owned.period)) choices.push_back({{owned.period, owned.execution}, k, 1});
      }
      for (int m = 2; m <= static_cast<int>(count); ++m) {
        double period = std::max(m * member.cost / instance.usable, member.least_period);
        if (member.exact_period > 0.0) {
          if (period > member.exact_period * (1.0 + kProven)) continue;
          period = member.exact_period;
        }
        choices.push_back({{period, period}, 1, m});
      }
      std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
        return a.timing.period + a.timing.execution < b.timing.period + b.timing.execution;
      });
    }
    chosen_.assign(count, 0);
    in_class_.assign(count + 1, 0);
    timings_.resize(count);
  }

  Planned run() {
    Planned planned;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      if (choices_[i].empty()) return planned;
      timings_[i] = shortest(i);
    }
    descend(0, 0);
    planned.found = std::isfinite(best_);
    if (!planned.found) return planned;
    planned.allocation = built();
    planned.shares.value = best_;
    planned.bound = effort_.left > 0 ? best_ : 0.0;
    return planned;
  }

 private:
  struct Choice {
    Timing timing;
    int cores = 1;
    int rivals = 1;  // how many share the core, itself included
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

  // Cores that the classes begun need, each of them full.
  int cores_needed(int owned) const {
    int cores = owned;
    for (std::size_t m = 2; m < in_class_.size(); ++m) {
      cores += static_cast<int>((static_cast<std::size_t>(in_class_[m]) + m - 1) / m);
    }
    return cores;
  }
  // Subchains that are still missing for all classes begun to be full.
  std::size_t missing() const {
    std::size_t sum = 0;
    for (std::size_t m = 2; m < in_class_.size(); ++m) {
      sum += (m - static_cast<std::size_t>(in_class_[m]) % m) % m;
    }
    return sum;
  }

  void descend(std::size_t i, int owned) {
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
      const bool shares = choice.rivals > 1;
      if (shares) ++in_class_[static_cast<std::size_t>(choice.rivals)];
      const int used = owned + (shares ? 0 : choice.cores);
      timings_[i] = choice.timing;
      chosen_[i] = c;
      effort_.spend(1);
      if (cores_needed(used) <= instance_.cores && missing() <= choices_.size() - i - 1 &&
          value() * (1.0 + kProven) < best_ && limits_hold()) {
        descend(i + 1, used);
      }
      if (shares) --in_class_[static_cast<std::size_t>(choice.rivals)];
    }
    timings_[i] = before;
  }

  Allocation built() const {
    Allocation allocation;
    allocation.core_of.assign(choices_.size(), -1);
    allocation.owned.assign(choices_.size(), 0);
    std::map<int, std::pair<int, int>> open;  // class: core, and how many it has
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const Choice& choice = choices_[i][best_choice_[i]];
      if (choice.rivals == 1) {
        allocation.owned[i] = choice.cores;
        continue;
      }
      auto& [core, members] = open.try_emplace(choice.rivals, -1, choice.rivals).first->second;
      if (members == choice.rivals) {
        core = allocation.shared_cores++;
        members = 0;
      }
      allocation.core_of[i] = core;
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
  std::vector<int> in_class_;  // by m
  std::vector<Timing> timings_;
  double best_ = kInfinity;
};

}  // namespace

Planned allocate_by_equal_shares(const Instance& instance, const Target& target, Effort& effort) {
  return StageOne(instance, target, effort).run();
}

}  // namespace ctn::planner
