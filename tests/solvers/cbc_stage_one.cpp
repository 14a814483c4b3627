#include "solvers/cbc_stage_one.h"

#include <coin/Cbc_C_Interface.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace ctn::solvers {
namespace {

using planner::Allocation;
using planner::Coefficient;
using planner::Form;
using planner::Group;
using planner::Instance;
using planner::Member;
using planner::Target;
using planner::Timing;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-10;

// A linear expression: columns with their factors.
struct Row {
  std::vector<int> columns;
  std::vector<double> factors;

  void add(int column, double factor) {
    const auto known = std::find(columns.begin(), columns.end(), column);
    if (known != columns.end()) {
      factors[static_cast<std::size_t>(known - columns.begin())] += factor;
      return;
    }
    columns.push_back(column);
    factors.push_back(factor);
  }
};

class Program {
 public:
  Program() : model_(Cbc_newModel()) { Cbc_setLogLevel(model_, 0); }
  ~Program() { Cbc_deleteModel(model_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  int binary() {
    Cbc_addCol(model_, "", 0.0, 1.0, 0.0, 1, 0, nullptr, nullptr);
    return columns_++;
  }
  int number(double cost) {
    Cbc_addCol(model_, "", 0.0, kInfinity, cost, 0, 0, nullptr, nullptr);
    return columns_++;
  }
  // `sense`: 'L' at most, 'G' at least, 'E' equal.
  void require(const Row& row, char sense, double bound) {
    Cbc_addRow(model_, "", static_cast<int>(row.columns.size()), row.columns.data(), row.factors.data(), sense, bound);
  }

  // True if there is a solution to read.
  bool solve(double seconds) {
    if (std::isfinite(seconds)) Cbc_setMaximumSeconds(model_, seconds);
    Cbc_setAllowableGap(model_, 0.0);
    Cbc_setAllowableFractionGap(model_, 0.0);
    Cbc_solve(model_);
    proven_ = Cbc_isProvenOptimal(model_) != 0 || Cbc_isProvenInfeasible(model_) != 0;
    if (Cbc_isProvenInfeasible(model_) != 0) return false;
    const double* solution = Cbc_bestSolution(model_);
    if (solution == nullptr) return false;
    solution_.assign(solution, solution + columns_);
    return true;
  }
  bool proven() const { return proven_; }
  bool is_set(int column) const { return solution_[static_cast<std::size_t>(column)] > 0.5; }

 private:
  Cbc_Model* model_;
  int columns_ = 0;
  bool proven_ = false;
  std::vector<double> solution_;
};

// A way for a subchain to run: alone on k cores, or as one of m.
struct Way {
  int column = 0;
  int cores = 1;
  int sharing = 1;
  Timing timing;
};

class Milp {
 public:
  Milp(const Instance& instance, const Target& target) : instance_(instance), target_(target) {
    add_ways();
    add_cores();
    add_objective();
  }

  StageOne solve(double seconds) {
    StageOne answer;
    answer.found = program_.solve(seconds);
    answer.proven = program_.proven();
    if (!answer.found) return answer;
    read(answer);
    return answer;
  }

 private:
  std::size_t count() const { return instance_.members.size(); }

  Timing shared(const Member& member, int sharing) const {
    double period = std::max(sharing * member.on[0].cost / instance_.usable, member.min_period);
    if (member.exact_period > 0.0) {
      period = period <= member.exact_period * (1.0 + kRounding) ? member.exact_period : kInfinity;
    }
    return {period, period};
  }

  void add_ways() {
    for (const Member& member : instance_.members) {
      std::vector<Way>& ways = ways_.emplace_back();
      const auto add = [&](int cores, int sharing, const Timing& timing) {
        if (std::isfinite(timing.period)) ways.push_back({program_.binary(), cores, sharing, timing});
      };
      for (std::size_t k = 0; k < member.on[0].owned.size(); ++k) {
        add(static_cast<int>(k + 1), 1, {member.on[0].owned[k].period, member.on[0].owned[k].execution});
      }
      for (int m = 2; m <= static_cast<int>(count()); ++m) add(1, m, shared(member, m));
      Row one;
      for (const Way& way : ways) one.add(way.column, 1.0);
      program_.require(one, 'E', 1.0);
    }
  }

  void add_cores() {
    const auto cores = static_cast<std::size_t>(instance_.cores());
    on_.assign(count(), std::vector<int>(cores));
    for (std::vector<int>& row : on_) {
      for (int& column : row) column = program_.binary();
    }
    for (std::size_t i = 0; i < count(); ++i) {
      Row as_many;
      for (const int column : on_[i]) as_many.add(column, 1.0);
      for (const Way& way : ways_[i]) as_many.add(way.column, -way.cores);
      program_.require(as_many, 'E', 0.0);
    }
    for (std::size_t x = 0; x < cores; ++x) add_core(x);
  }

  // Of how many the core is, and that its subchains run accordingly.
  void add_core(std::size_t x) {
    std::vector<int> size;
    Row one;
    Row counted;
    for (std::size_t m = 0; m <= count(); ++m) {
      size.push_back(program_.binary());
      one.add(size.back(), 1.0);
      counted.add(size.back(), -static_cast<double>(m));
    }
    for (std::size_t i = 0; i < count(); ++i) counted.add(on_[i][x], 1.0);
    program_.require(one, 'E', 1.0);
    program_.require(counted, 'E', 0.0);
    for (std::size_t i = 0; i < count(); ++i) {
      for (std::size_t m = 1; m <= count(); ++m) {
        Row so;
        for (const Way& way : ways_[i]) {
          if (way.sharing == static_cast<int>(m)) so.add(way.column, 1.0);
        }
        so.add(on_[i][x], -1.0);
        so.add(size[m], -1.0);
        program_.require(so, 'G', -1.0);
      }
    }
  }

  // The form without its constant.
  Row row_of(const Form& form) const {
    Row row;
    for (const Coefficient& c : form.coefficients) {
      for (const Way& way : ways_[static_cast<std::size_t>(c.subchain)]) {
        row.add(way.column, c.period * way.timing.period + c.execution * way.timing.execution);
      }
    }
    return row;
  }

  void add_objective() {
    for (const Group& group : target_.groups) {
      const int largest = program_.number(group.weight);
      for (const Form& form : group.forms) {
        Row above = row_of(form);
        above.add(largest, -1.0);
        program_.require(above, 'L', -form.constant);
      }
    }
    for (const Group& limit : target_.limits) {
      for (const Form& form : limit.forms) program_.require(row_of(form), 'L', limit.limit - form.constant);
    }
  }

  void read(StageOne& answer) const {
    Allocation& allocation = answer.allocation;
    allocation = planner::Allocation::none(count());
    std::vector<Timing> timings;
    std::vector<int> number(static_cast<std::size_t>(instance_.cores()), -1);
    for (std::size_t i = 0; i < count(); ++i) {
      const auto way =
          std::find_if(ways_[i].begin(), ways_[i].end(), [&](const Way& w) { return program_.is_set(w.column); });
      timings.push_back(way->timing);
      if (way->sharing == 1) {
        allocation.owned[i] = way->cores;
        continue;
      }
      std::size_t core = 0;
      while (!program_.is_set(on_[i][core])) ++core;
      if (number[core] < 0) number[core] = allocation.shared_cores++;
      allocation.core_of[i] = number[core];
    }
    answer.value = 0.0;
    for (const Group& group : target_.groups) answer.value += group.weight * value_of(group, timings);
  }

  const Instance& instance_;
  const Target& target_;
  Program program_;
  std::vector<std::vector<Way>> ways_;  // by subchain
  std::vector<std::vector<int>> on_;    // by subchain and core
};

}  // namespace

StageOne cbc_stage_one(const Instance& instance, const Target& target, double seconds) {
  return Milp(instance, target).solve(seconds);
}

}  // namespace ctn::solvers
