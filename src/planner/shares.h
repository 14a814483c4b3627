// Stage II: given who shares which core, how often each subchain runs and how long each frame is. All cores at once,
// because the longest period of a chain that crosses cores couples them.
//
// Branch and bound over the whole numbers n. The bound is Lagrangian: each maximum of forms is replaced by a weighted
// mean of them (weights from the simplex), each bound by its price; what is left is linear, so that every core is
// solved by itself, exactly in whole numbers (shared_core.h). The best multipliers are approached by subgradient steps,
// and passed down the tree. The bound thus knows of whole numbers from the start: where no maximum is contested, it is
// the optimum and nothing is branched on. Where all n are fixed, free shares are optimised by an interior-point method
// (frame_fit.h).
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "planner/instance.h"
#include "planner/shared_core.h"

namespace ctn::planner {

// Who has which cores.
struct Allocation {
  std::vector<int> core_of;  // by subchain: the shared core; -1: it owns `owned` cores
  std::vector<int> owned;    // by subchain: how many; 0 on a shared core
  std::vector<int> kind;     // by subchain: of its cores
  int shared_cores = 0;

  // Nobody has anything yet.
  static Allocation none(std::size_t subchains) {
    return {std::vector<int>(subchains, -1), std::vector<int>(subchains, 0), std::vector<int>(subchains, 0), 0};
  }
  void own(std::size_t subchain, int cores, int of_kind) {
    owned[subchain] = cores;
    kind[subchain] = of_kind;
  }
  // On the shared core that is numbered last.
  void share(std::size_t subchain, int of_kind) {
    core_of[subchain] = shared_cores - 1;
    kind[subchain] = of_kind;
  }

  friend bool operator==(const Allocation&, const Allocation&) = default;
};

// What is to be minimised, and what must hold: the objective under bounds scaled by a factor, or that factor itself.
struct Target {
  std::vector<Group> groups;
  std::vector<Group> limits;
};

Target objective_target(const Instance& instance, double factor);
Target free_target(const Instance& instance);  // the objective without bounds
Target factor_target(const Instance& instance);

struct Shares {
  bool found = false;
  double value = std::numeric_limits<double>::infinity();
  double bound = 0.0;           // proven: no value is below it
  std::vector<Timing> timings;  // by subchain
  std::vector<double> frames;   // T, by shared core
};

// Beyond so many subchains what was cheap may take long: it is paid for by what it takes, and left out where that is
// more than there is.
constexpr std::size_t kCheap = 64;

// Counts bound evaluations and walked steps, so that a search ends after the same work everywhere.
struct Effort {
  std::size_t left = std::numeric_limits<std::size_t>::max();

  bool spend(std::size_t units) {
    left = left > units ? left - units : 0;
    return left > 0;
  }
};

class SharesSolver {
 public:
  SharesSolver(const Instance& instance, const Target& target);

  // The best shares if they are better than `cutoff`. Where the effort runs out, what was found and what was proven.
  Shares solve(const Allocation& allocation, double cutoff, Effort& effort);

  // The linear part of the bound: what each period and execution time costs under the current multipliers.
  struct Prices {
    std::vector<double> period;
    std::vector<double> execution;
    double constant = 0.0;
  };
  const Prices& prices();
  const std::vector<double>& multipliers() const { return multipliers_; }
  void set_multipliers(std::vector<double> multipliers) { multipliers_ = std::move(multipliers); }
  // A lower bound of what a group on one core costs under these prices.
  double price_of_shared(const std::vector<int>& members, int kind);
  double price_of_owned(int subchain, int cores, int kind);
  // Walked along cores since the object was made (shared_core.h).
  std::size_t steps() const { return core_.steps(); }

 private:
  struct Box {
    std::vector<double> least;
    std::vector<double> most;
  };
  struct Node {
    Box box;
    std::vector<double> multipliers;
    double bound = 0.0;
  };
  // The minimiser of the Lagrangian at the present multipliers.
  struct Point {
    bool feasible = false;
    double value = 0.0;
    std::vector<Timing> timings;
    std::vector<double> every;
    std::vector<double> frames;
    std::vector<int> split;  // at most one on each core: its n is not whole, though it should be
  };

  void place(std::size_t i, int kind);
  const Owned& owned(std::size_t i, const Allocation& allocation) const;
  void price();
  bool limit_frames(const Box& box);
  double weight(std::size_t i) const { return prices_.period[i] + prices_.execution[i]; }
  void price_caps(const std::vector<int>& members, double usable);
  double solve_core(const std::vector<int>& members, std::size_t core, const Box& box);
  void relax(const Allocation& allocation, const Box& box);
  bool adjust(double goal, double level);
  void start_caps();
  double climb(const Allocation& allocation, const Box& box);
  void consider(const Allocation& allocation);
  void consider_every(const Allocation& allocation, const std::vector<double>& every);
  bool fit_core(int core, const std::vector<double>& every, std::vector<Timing>& timings, double& frame) const;
  void keep(const std::vector<Timing>& timings, const std::vector<double>& frames);
  int divide_group(const Box& box, const Group& group, const double* multiplier, double& at) const;
  int branch_on(const Box& box, double& at) const;
  bool hopeless(const Box& box);
  std::size_t fit_effort() const;
  bool finish_leaf(const Allocation& allocation, const Box& box, bool may_fit);
  void explore(const Allocation& allocation, Node node, std::vector<Node>& open, Effort& effort);
  void prepare(const Allocation& allocation);
  double known() const { return std::min(best_.value, cutoff_); }
  bool shared(std::size_t i, const Allocation& allocation) const { return allocation.core_of[i] >= 0; }

  const Instance& instance_;
  const Target& target_;
  bool contested_ = false;            // the multipliers have something to decide
  std::vector<std::size_t> offsets_;  // of each group's, then each limit's, then the caps' first multiplier
  std::vector<double> multipliers_;
  Prices prices_;
  Point point_;
  Shares best_;
  double cutoff_ = 0.0;
  double unfitted_ = 0.0;            // a bound of what is left open where free shares were not fitted
  std::size_t rounds_ = 0;           // of the last climb
  std::vector<double> least_frame_;  // by shared core
  std::vector<double> most_frame_;
  std::vector<double> usable_;
  std::vector<std::vector<int>> members_;  // by shared core
  std::vector<double> cost_;               // by subchain: on the kind of cores that it has
  std::vector<double> steepness_;          // by multiplier: the last subgradient
  std::vector<double> cap_price_;          // by subchain: of its rate cap, in the last core solved
  const SharedCore::Answer* answer_ = nullptr;
  std::vector<double> scratch_;
  Box full_;
  SharedCore core_;
};

// What is proven equal: values that differ by less than this part.
constexpr double kProven = 1e-10;

// A bound from here up proves that nothing is better than `known`, a value >= 0 that may be infinite.
inline double proof_of(double known) { return known * (1.0 - kProven); }

}  // namespace ctn::planner
