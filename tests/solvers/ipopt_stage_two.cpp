#include "solvers/ipopt_stage_two.h"

#include <coin/IpStdCInterface.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

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

constexpr double kNone = 1e19;  // what Ipopt takes for no bound

// Every row is a sum of factor * x, or of factor / x: the latter where `inverse`.
struct Row {
  double most = kNone;
  double least = -kNone;
  bool inverse = false;
  std::vector<std::pair<int, double>> terms;
};

struct Program {
  std::vector<double> least;
  std::vector<double> most;
  std::vector<double> start;
  std::vector<double> cost;
  std::vector<Row> rows;

  int add(double from, double to, double at, double weight) {
    least.push_back(from);
    most.push_back(to);
    start.push_back(at);
    cost.push_back(weight);
    return static_cast<int>(least.size()) - 1;
  }
};

const Program& program_of(UserDataPtr data) { return *static_cast<const Program*>(data); }

Bool eval_f(Index n, Number* x, Bool /*fresh*/, Number* value, UserDataPtr data) {
  *value = 0.0;
  for (Index i = 0; i < n; ++i) *value += program_of(data).cost[static_cast<std::size_t>(i)] * x[i];
  return 1;
}

Bool eval_gradient(Index n, Number* /*x*/, Bool /*fresh*/, Number* gradient, UserDataPtr data) {
  std::copy_n(program_of(data).cost.begin(), n, gradient);
  return 1;
}

Bool eval_g(Index /*n*/, Number* x, Bool /*fresh*/, Index /*m*/, Number* g, UserDataPtr data) {
  for (const Row& row : program_of(data).rows) {
    *g = 0.0;
    for (const auto& [column, factor] : row.terms) *g += row.inverse ? factor / x[column] : factor * x[column];
    ++g;
  }
  return 1;
}

// Ipopt asks for the places first, then, with `values`, for what is there.
Bool eval_jacobian(Index /*n*/, Number* x, Bool /*fresh*/, Index /*m*/, Index /*entries*/, Index* rows, Index* columns,
                   Number* values, UserDataPtr data) {
  std::size_t entry = 0;
  Index r = 0;
  for (const Row& row : program_of(data).rows) {
    for (const auto& [column, factor] : row.terms) {
      if (values == nullptr) {
        rows[entry] = r;
        columns[entry] = column;
      } else {
        values[entry] = row.inverse ? -factor / (x[column] * x[column]) : factor;
      }
      ++entry;
    }
    ++r;
  }
  return 1;
}

// Only rows of inverses curve, and each variable by itself.
Bool eval_hessian(Index /*n*/, Number* x, Bool /*fresh*/, Number /*objective*/, Index /*m*/, Number* prices,
                  Bool /*fresh_prices*/, Index /*entries*/, Index* rows, Index* columns, Number* values,
                  UserDataPtr data) {
  std::size_t entry = 0;
  std::size_t r = 0;
  for (const Row& row : program_of(data).rows) {
    if (row.inverse) {
      for (const auto& [column, factor] : row.terms) {
        if (values == nullptr) {
          rows[entry] = columns[entry] = column;
        } else {
          values[entry] = prices[r] * 2.0 * factor / (x[column] * x[column] * x[column]);
        }
        ++entry;
      }
    }
    ++r;
  }
  return 1;
}

class Relaxation {
 public:
  Relaxation(const Instance& instance, const Target& target, const Allocation& allocation)
      : instance_(instance), target_(target), allocation_(allocation) {
    add_periods();
    add_objective();
  }

  StageTwo solve() {
    Index in_jacobian = 0;
    Index in_hessian = 0;
    std::vector<double> row_least;
    std::vector<double> row_most;
    for (const Row& row : program_.rows) {
      in_jacobian += static_cast<Index>(row.terms.size());
      if (row.inverse) in_hessian += static_cast<Index>(row.terms.size());
      row_least.push_back(row.least);
      row_most.push_back(row.most);
    }
    const IpoptProblem problem =
        CreateIpoptProblem(static_cast<Index>(program_.cost.size()), program_.least.data(), program_.most.data(),
                           static_cast<Index>(program_.rows.size()), row_least.data(), row_most.data(), in_jacobian,
                           in_hessian, 0, eval_f, eval_g, eval_gradient, eval_jacobian, eval_hessian);
    set_options(problem);
    std::vector<double> x = program_.start;
    const ApplicationReturnStatus status =
        IpoptSolve(problem, x.data(), nullptr, nullptr, nullptr, nullptr, nullptr, &program_);
    FreeIpoptProblem(problem);
    return read(x, status == Solve_Succeeded);
  }

 private:
  static void set_options(IpoptProblem problem) {
    // The C interface asks for texts that it may write to, though it does not.
    const auto text = [&](std::string key, std::string value) { AddIpoptStrOption(problem, key.data(), value.data()); };
    const auto number = [&](std::string key, double value) { AddIpoptNumOption(problem, key.data(), value); };
    const auto whole = [&](std::string key, int value) { AddIpoptIntOption(problem, key.data(), value); };
    whole("print_level", 0);
    text("sb", "yes");
    text("mu_strategy", "adaptive");
    number("tol", 1e-10);
    number("bound_relax_factor", 0.0);
  }

  void add_periods() {
    std::vector<double> load(static_cast<std::size_t>(allocation_.shared_cores), 0.0);
    for (std::size_t i = 0; i < instance_.members.size(); ++i) {
      if (allocation_.core_of[i] >= 0) load[static_cast<std::size_t>(allocation_.core_of[i])] += 1.0;
    }
    for (std::size_t i = 0; i < instance_.members.size(); ++i) add_period(i, load);
    for (int core = 0; core < allocation_.shared_cores; ++core) add_core(core);
  }

  void add_period(std::size_t i, const std::vector<double>& load) {
    const Member& member = instance_.members[i];
    double least = std::max(member.min_period, 1e-6 * member.on[0].cost);
    double most = kNone;
    double start = 0.0;
    double execution = -1.0;
    if (allocation_.core_of[i] < 0) {
      const planner::Owned& owned = member.on[0].owned[static_cast<std::size_t>(allocation_.owned[i] - 1)];
      least = most = start = owned.period;
      execution = owned.execution;
    } else if (member.exact_period > 0.0) {
      least = most = start = member.exact_period;
    } else {
      const double equal =
          load[static_cast<std::size_t>(allocation_.core_of[i])] * member.on[0].cost / instance_.usable;
      start = std::max(1.1 * equal, member.min_period);
    }
    periods_.push_back(program_.add(least, most, start, 0.0));
    executions_.push_back(execution);
  }

  void add_core(int core) {
    Row busy;
    busy.inverse = true;
    busy.most = instance_.usable;
    double shortest = kNone;
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < instance_.members.size(); ++i) {
      if (allocation_.core_of[i] != core) continue;
      members.push_back(i);
      busy.terms.emplace_back(periods_[i], instance_.members[i].on[0].cost);
      shortest = std::min(shortest, program_.start[static_cast<std::size_t>(periods_[i])]);
    }
    program_.rows.push_back(busy);
    const int frame = program_.add(0.0, kNone, shortest, 0.0);
    for (const std::size_t i : members) {
      const Member& member = instance_.members[i];
      if (!member.queue) program_.rows.push_back({0.0, -kNone, false, {{frame, 1.0}, {periods_[i], -1.0}}});
      program_.rows.push_back({0.0, -kNone, false, {{periods_[i], 1.0}, {frame, -member.on[0].most_every}}});
    }
  }

  // The form as a row; what no variable decides goes into its bound.
  Row row_of(const Form& form, double at_most) const {
    Row row;
    row.most = at_most - form.constant;
    for (const Coefficient& c : form.coefficients) {
      const auto i = static_cast<std::size_t>(c.subchain);
      double factor = c.period;
      if (executions_[i] < 0.0) {
        factor += c.execution;
      } else {
        row.most -= c.execution * executions_[i];
      }
      if (factor != 0.0) row.terms.emplace_back(periods_[i], factor);
    }
    return row;
  }

  void add_objective() {
    for (const Group& group : target_.groups) {
      const double start = value_of(group, timings(program_.start));
      const int largest = program_.add(0.0, kNone, 1.1 * start + 1e-3, group.weight);
      for (const Form& form : group.forms) {
        Row below = row_of(form, 0.0);
        below.terms.emplace_back(largest, -1.0);
        program_.rows.push_back(std::move(below));
      }
    }
    for (const Group& limit : target_.limits) {
      for (const Form& form : limit.forms) program_.rows.push_back(row_of(form, limit.limit));
    }
  }

  std::vector<Timing> timings(const std::vector<double>& x) const {
    std::vector<Timing> found;
    for (std::size_t i = 0; i < periods_.size(); ++i) {
      const double period = x[static_cast<std::size_t>(periods_[i])];
      found.push_back({period, executions_[i] < 0.0 ? period : executions_[i]});
    }
    return found;
  }

  StageTwo read(const std::vector<double>& x, bool solved) const {
    StageTwo answer;
    answer.solved = solved;
    answer.timings = timings(x);
    answer.value = 0.0;
    for (const Group& group : target_.groups) answer.value += group.weight * value_of(group, answer.timings);
    return answer;
  }

  const Instance& instance_;
  const Target& target_;
  const Allocation& allocation_;
  Program program_;
  std::vector<int> periods_;        // by subchain: its column
  std::vector<double> executions_;  // by subchain; negative: as long as its period
};

}  // namespace

StageTwo ipopt_stage_two(const Instance& instance, const Target& target, const Allocation& allocation) {
  return Relaxation(instance, target, allocation).solve();
}

}  // namespace ctn::solvers
