// Stage I, section 5.1, where not all allocations can be looked at, and to begin with where they can.
#include "paper/local_search.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "paper/equal_shares.h"

namespace ctn::paper {
namespace {

// Subchains on cores; a core that a subchain has to itself may be lent others of its kind.
struct Cores {
  std::vector<int> core_of;  // by subchain
  std::vector<int> lent;     // by core: how many more its owner has
};

class LocalSearch {
 public:
  LocalSearch(const Problem& problem, std::size_t steps) : problem_(problem), steps_(steps) {
    for (std::size_t kind = 0; kind < problem.cores.size(); ++kind) {
      kind_of_.insert(kind_of_.end(), static_cast<std::size_t>(problem.cores[kind]), static_cast<int>(kind));
    }
  }

  Allocation run() {
    best_ = dealt();
    value_ = value_at(best_);
    while (steps_ > 0 && (move_any() || swap_any() || lend_any())) {
    }
    fill_cores();
    return allocation_of(best_);
  }

 private:
  std::size_t subchains() const { return problem_.subchains.size(); }
  std::size_t cores() const { return kind_of_.size(); }
  static std::size_t index(int number) { return static_cast<std::size_t>(number); }

  // One after the other to the core that has least to do, heavy ones first.
  Cores dealt() const {
    Cores state{std::vector<int>(subchains()), std::vector<int>(cores(), 0)};
    std::vector<std::size_t> order(subchains());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return problem_.on(a, 0).cost > problem_.on(b, 0).cost; });
    std::vector<double> busy(cores(), 0.0);
    for (const std::size_t i : order) {
      std::size_t best = 0;
      for (std::size_t core = 1; core < cores(); ++core) {
        if (busy[core] + problem_.on(i, kind_of_[core]).cost < busy[best] + problem_.on(i, kind_of_[best]).cost) {
          best = core;
        }
      }
      state.core_of[i] = static_cast<int>(best);
      busy[best] += problem_.on(i, kind_of_[best]).cost;
    }
    return state;
  }

  std::vector<int> members(const Cores& state) const {
    std::vector<int> count(cores(), 0);
    for (const int core : state.core_of) ++count[index(core)];
    return count;
  }
  // How many cores of the kind no subchain has; less than 0: the state cannot be.
  int spare(const Cores& state, const std::vector<int>& count, int kind) const {
    int spare = 0;
    for (std::size_t core = 0; core < cores(); ++core) {
      if (kind_of_[core] == kind) spare += (count[core] == 0 ? 1 : 0) - state.lent[core];
    }
    return spare;
  }

  EqualShares value_at(const Cores& state) {
    if (steps_ > 0) --steps_;
    const std::vector<int> count = members(state);
    for (std::size_t kind = 0; kind < problem_.cores.size(); ++kind) {
      if (spare(state, count, static_cast<int>(kind)) < 0) return {};
    }
    std::vector<Timing> timings(subchains());
    for (std::size_t i = 0; i < subchains(); ++i) {
      const std::size_t core = index(state.core_of[i]);
      if (count[core] > 1 && state.lent[core] > 0) return {};
      timings[i] = count[core] > 1 ? shared_timing(problem_, i, kind_of_[core], count[core])
                                   : owned_timing(problem_, i, kind_of_[core], 1 + state.lent[core]);
    }
    return value_of(problem_, timings);
  }

  bool take(Cores state) {
    const EqualShares value = value_at(state);
    if (!value.clearly_below(value_)) return false;
    best_ = std::move(state);
    value_ = value;
    return true;
  }

  // To another core; where all are taken, to one that an owner was lent.
  bool move_any() {
    bool better = false;
    for (std::size_t i = 0; i < subchains() && steps_ > 0; ++i) {
      for (std::size_t core = 0; core < cores() && steps_ > 0; ++core) {
        Cores state = best_;
        const std::size_t from = index(state.core_of[i]);
        if (from == core) continue;
        state.core_of[i] = static_cast<int>(core);
        state.lent[from] = 0;
        const int kind = kind_of_[core];
        const std::vector<int> count = members(state);
        for (std::size_t other = 0; other < cores() && spare(state, count, kind) < 0; ++other) {
          if (kind_of_[other] == kind && state.lent[other] > 0) --state.lent[other];
        }
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  bool swap_any() {
    bool better = false;
    for (std::size_t i = 0; i < subchains() && steps_ > 0; ++i) {
      for (std::size_t j = i + 1; j < subchains() && steps_ > 0; ++j) {
        if (best_.core_of[i] == best_.core_of[j]) continue;
        Cores state = best_;
        std::swap(state.core_of[i], state.core_of[j]);
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  // A core that no subchain has, or that another was lent.
  bool lend_any() {
    bool better = false;
    for (std::size_t to = 0; to < cores() && steps_ > 0; ++to) {
      if (Cores state = best_; spare(state, members(state), kind_of_[to]) > 0) {
        ++state.lent[to];
        better = take(std::move(state)) || better;
      }
      for (std::size_t from = 0; from < cores() && steps_ > 0; ++from) {
        if (from == to || kind_of_[from] != kind_of_[to] || best_.lent[from] == 0) continue;
        Cores state = best_;
        --state.lent[from];
        ++state.lent[to];
        better = take(std::move(state)) || better;
      }
    }
    return better;
  }

  // No core is left without a subchain while another of its kind is shared.
  void fill_cores() {
    for (std::vector<int> count = members(best_);; count = members(best_)) {
      std::optional<std::size_t> leaves;
      std::size_t to = 0;
      for (std::size_t core = 0; core < cores(); ++core) {
        if (count[core] > 0 || spare(best_, count, kind_of_[core]) <= 0) continue;
        for (std::size_t i = 0; i < subchains() && !leaves; ++i) {
          const std::size_t at = index(best_.core_of[i]);
          if (count[at] > 1 && kind_of_[at] == kind_of_[core]) leaves = i;
        }
        to = core;
        if (leaves) break;
      }
      if (!leaves) return;
      best_.core_of[*leaves] = static_cast<int>(to);
    }
  }

  Allocation allocation_of(const Cores& state) const {
    const std::vector<int> count = members(state);
    Allocation allocation;
    std::map<int, int> number;
    for (const int core : state.core_of) {
      Place place;
      place.kind = kind_of_[index(core)];
      if (count[index(core)] > 1) {
        place.shared = number.try_emplace(core, static_cast<int>(number.size())).first->second;
      } else {
        place.owned = 1 + state.lent[index(core)];
      }
      allocation.push_back(place);
    }
    return allocation;
  }

  const Problem& problem_;
  std::size_t steps_;
  std::vector<int> kind_of_;  // by core
  Cores best_;
  EqualShares value_;
};

}  // namespace

Allocation search_locally(const Problem& problem, std::size_t steps) { return LocalSearch(problem, steps).run(); }

}  // namespace ctn::paper
