#include "planner/frame_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "model/portable_math.h"
#include "planner/shares.h"

namespace ctn::planner {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kGap = 1e-12;    // of the value, at the end
constexpr double kGrowth = 30.0;  // of the barrier's parameter from one centring to the next
constexpr int kNewtonSteps = 60;  // of one centring
constexpr int kDoublings = 60;    // of a frame, looking for one with room
constexpr double kPenalty = 1e4;  // of a missed limit, in objectives

// A linear quantity in the variables.
struct Linear {
  double constant = 0.0;
  std::vector<std::pair<int, double>> terms;

  double at(const Vector& z) const {
    double value = constant;
    for (const auto& [variable, factor] : terms) value += factor * z[variable];
    return value;
  }
};

// usable - sum of C / x over the core's variables.
struct Room {
  double usable = 0.0;
  std::vector<std::pair<int, double>> terms;

  double at(const Vector& z) const {
    double value = usable;
    for (const auto& [variable, cost] : terms) value -= cost / z[variable];
    return value;
  }
};

class Barrier {
 public:
  Linear cost;
  std::vector<Linear> linear;  // each >= 0
  std::vector<Room> rooms;     // each >= 0

  std::size_t constraints() const { return linear.size() + rooms.size(); }

  bool inside(const Vector& z) const {
    return std::all_of(linear.begin(), linear.end(), [&](const Linear& c) { return c.at(z) > 0.0; }) &&
           std::all_of(rooms.begin(), rooms.end(), [&](const Room& c) { return c.at(z) > 0.0; }) && z.minCoeff() > 0.0;
  }

  double value(const Vector& z, double t) const {
    double sum = t * cost.at(z);
    for (const Linear& c : linear) sum -= model::portable_log(c.at(z));
    for (const Room& c : rooms) sum -= model::portable_log(c.at(z));
    return sum;
  }

  void derivatives(const Vector& z, double t, Vector& gradient, Matrix& hessian) const {
    gradient.setZero(z.size());
    hessian.setZero(z.size(), z.size());
    for (const auto& [variable, factor] : cost.terms) gradient[variable] += t * factor;
    for (const Linear& c : linear) {
      const double slack = c.at(z);
      for (const auto& [i, a] : c.terms) {
        gradient[i] -= a / slack;
        for (const auto& [j, b] : c.terms) hessian(i, j) += a * b / (slack * slack);
      }
    }
    for (const Room& c : rooms) {
      const double slack = c.at(z);
      for (const auto& [i, a] : c.terms) {
        const double slope_i = a / (z[i] * z[i]);
        gradient[i] -= slope_i / slack;
        hessian(i, i) += 2.0 * slope_i / z[i] / slack;
        for (const auto& [j, b] : c.terms) hessian(i, j) += slope_i * b / (z[j] * z[j]) / (slack * slack);
      }
    }
  }

  // From a point inside to the optimum, near enough.
  void minimise(Vector& z) const {
    const double scale = std::max(1e-300, std::abs(cost.at(z)));
    const double m = static_cast<double>(constraints());
    for (double t = m / scale;; t *= kGrowth) {
      centre(z, t);
      if (m / t < kGap * std::max(1e-300, std::abs(cost.at(z)))) return;
    }
  }

 private:
  void centre(Vector& z, double t) const {
    Vector gradient;
    Matrix hessian;
    for (int step = 0; step < kNewtonSteps; ++step) {
      derivatives(z, t, gradient, hessian);
      const Vector direction = -hessian.ldlt().solve(gradient);
      const double decrement = -gradient.dot(direction);
      if (!(decrement > 1e-10)) return;
      const double before = value(z, t);
      double length = 1.0;
      Vector next = z + direction;
      while (length > 1e-12 && (!inside(next) || !(value(next, t) <= before - 0.1 * length * decrement))) {
        length *= 0.5;
        next = z + length * direction;
      }
      if (length <= 1e-12) return;
      z = next;
    }
  }
};

class Fit {
 public:
  Fit(const FrameFit& input, const std::vector<double>& every, std::vector<Timing>& timings,
      std::vector<double>& frames)
      : in_(input), every_(every), timings_(timings), frames_(frames) {}

  bool solve() {
    period_of_.assign(in_.instance.members.size(), Linear{});
    execution_of_.assign(in_.instance.members.size(), Linear{});
    for (std::size_t i = 0; i < in_.instance.members.size(); ++i) {
      period_of_[i].constant = timings_[i].period;
      execution_of_[i].constant = timings_[i].execution;
    }
    frame_of_.resize(in_.members.size());
    for (std::size_t core = 0; core < in_.members.size(); ++core) {
      if (!add_core(core)) return false;
    }
    add_target();
    Vector z = Eigen::Map<const Vector>(start_.data(), static_cast<Eigen::Index>(start_.size()));
    if (start_.empty() || !barrier_.inside(z)) return false;
    barrier_.minimise(z);
    for (std::size_t i = 0; i < timings_.size(); ++i) {
      timings_[i] = {period_of_[i].at(z), execution_of_[i].at(z)};
    }
    for (std::size_t core = 0; core < frame_of_.size(); ++core) frames_[core] = frame_of_[core].at(z);
    return true;
  }

 private:
  int variable(double start) {
    start_.push_back(start);
    return static_cast<int>(start_.size()) - 1;
  }

  const Member& member(int index) const { return in_.instance.members[static_cast<std::size_t>(index)]; }
  double cost(int index) const { return in_.cost[static_cast<std::size_t>(index)]; }
  double most_every(int index) const { return in_.most_every[static_cast<std::size_t>(index)]; }

  bool add_core(std::size_t core) {
    double busy = 0.0;
    double least = in_.min_frame[core];
    double most = in_.max_frame[core];
    std::vector<int> free;
    for (const int index : in_.members[core]) {
      const Member& m = member(index);
      const double n = every_[static_cast<std::size_t>(index)];
      if (m.queue) {
        if (m.exact_period == 0.0) free.push_back(index);
        continue;
      }
      busy += cost(index) / n;
      least = std::max(least, m.min_period / n);
      if (m.exact_period > 0.0) {
        least = std::max(least, m.exact_period / n);
        most = std::min(most, m.exact_period / n);
      }
    }
    const double usable = in_.usable[core];
    if (free.empty()) {
      frame_of_[core].constant = std::max(busy / usable, least);
    } else if (most <= least * (1.0 + 1e-9)) {
      frame_of_[core].constant = least;
      if (!place_free(core, free, usable - busy / least, least)) return false;
    } else if (!place_frame(core, free, busy, usable, least, most)) {
      return false;
    }
    for (const int index : in_.members[core]) {
      const auto i = static_cast<std::size_t>(index);
      const Member& m = member(index);
      if (m.queue && m.exact_period == 0.0) continue;
      Linear period{m.exact_period, {}};
      if (m.exact_period == 0.0) {
        period.constant = every_[i] * frame_of_[core].constant;
        for (const auto& [v, factor] : frame_of_[core].terms) period.terms.emplace_back(v, every_[i] * factor);
      }
      period_of_[i] = execution_of_[i] = period;
    }
    return true;
  }

  // The frame is given: only the periods of the free ones are to be found.
  bool place_free(std::size_t core, const std::vector<int>& free, double room, double frame) {
    Room left{room, {}};
    for (const int index : free) {
      const Member& m = member(index);
      const double longest = most_every(index) * frame;
      if (!(longest > m.min_period)) return false;
      const int v = variable(m.min_period + 0.95 * (longest - m.min_period));
      left.terms.emplace_back(v, cost(index));
      barrier_.linear.push_back({longest, {{v, -1.0}}});
      if (m.min_period > 0.0) barrier_.linear.push_back({-m.min_period, {{v, 1.0}}});
      set_free(index, v);
    }
    static_cast<void>(core);
    barrier_.rooms.push_back(std::move(left));
    return true;
  }

  bool place_frame(std::size_t core, const std::vector<int>& free, double busy, double usable, double least,
                   double most) {
    double frame = std::max({least, busy / usable, 1e-9}) * 1.01;
    for (int doubling = 0;; ++doubling) {
      if (doubling == kDoublings) return false;
      if (frame >= most) frame = least + 0.99 * (most - least);
      double room = usable - busy / frame;
      bool fits = true;
      for (const int index : free) {
        const Member& m = member(index);
        fits = fits && most_every(index) * frame > m.min_period * 1.0001;
        room -= cost(index) / (most_every(index) * frame * 0.999);
      }
      if (fits && room > 0.0) break;
      if (frame >= least + 0.98 * (most - least)) return false;
      frame *= 2.0;
    }
    const int t = variable(frame);
    frame_of_[core].terms.emplace_back(t, 1.0);
    if (least > 0.0) barrier_.linear.push_back({-least, {{t, 1.0}}});
    barrier_.linear.push_back({most, {{t, -1.0}}});
    Room left{usable, {}};
    if (busy > 0.0) left.terms.emplace_back(t, busy);
    for (const int index : free) {
      const Member& m = member(index);
      const double longest = most_every(index) * frame;
      const int v = variable(std::max(0.9995 * longest, 0.5 * (m.min_period + longest)));
      left.terms.emplace_back(v, cost(index));
      barrier_.linear.push_back({0.0, {{t, most_every(index)}, {v, -1.0}}});
      if (m.min_period > 0.0) barrier_.linear.push_back({-m.min_period, {{v, 1.0}}});
      set_free(index, v);
    }
    barrier_.rooms.push_back(std::move(left));
    return true;
  }

  void set_free(int index, int v) {
    const auto i = static_cast<std::size_t>(index);
    period_of_[i] = execution_of_[i] = Linear{0.0, {{v, 1.0}}};
  }

  Linear in_variables(const Form& form, double factor) const {
    Linear sum{factor * form.constant, {}};
    const auto add = [&](const Linear& part, double by) {
      sum.constant += by * part.constant;
      for (const auto& [v, f] : part.terms) sum.terms.emplace_back(v, by * f);
    };
    for (const Coefficient& c : form.coefficients) {
      const auto i = static_cast<std::size_t>(c.subchain);
      if (c.period != 0.0) add(period_of_[i], factor * c.period);
      if (c.execution != 0.0) add(execution_of_[i], factor * c.execution);
    }
    return sum;
  }

  double now(const Linear& quantity) const {
    return quantity.at(Eigen::Map<const Vector>(start_.data(), static_cast<Eigen::Index>(start_.size())));
  }

  // form <= top, a variable above all forms of the group.
  int add_top(const Group& group) {
    double largest = 0.0;
    std::vector<Linear> forms;
    for (const Form& form : group.forms) {
      forms.push_back(in_variables(form, -1.0));
      largest = std::max(largest, -now(forms.back()));
    }
    const int top = variable(1.1 * largest + 1e-6);
    for (Linear& form : forms) {
      form.terms.emplace_back(top, 1.0);
      barrier_.linear.push_back(std::move(form));
    }
    return top;
  }

  void add_target() {
    double scale = 0.0;
    for (const Group& group : in_.target.groups) {
      if (group.weight <= 0.0) continue;
      if (group.forms.size() == 1) {
        const Linear linear = in_variables(group.forms.front(), group.weight);
        barrier_.cost.constant += linear.constant;
        barrier_.cost.terms.insert(barrier_.cost.terms.end(), linear.terms.begin(), linear.terms.end());
      } else {
        barrier_.cost.terms.emplace_back(add_top(group), group.weight);
      }
    }
    scale = now(barrier_.cost);
    for (const Group& limit : in_.target.limits) {
      double over = 0.0;
      std::vector<Linear> forms;
      for (const Form& form : limit.forms) {
        forms.push_back(in_variables(form, -1.0 / limit.limit));
        forms.back().constant += 1.0;
        over = std::max(over, -now(forms.back()));
      }
      const int miss = variable(1.1 * over + 0.1);
      for (Linear& form : forms) {
        form.terms.emplace_back(miss, 1.0);
        barrier_.linear.push_back(std::move(form));
      }
      barrier_.linear.push_back({0.0, {{miss, 1.0}}});
      barrier_.cost.terms.emplace_back(miss, kPenalty * std::max(scale, 1e-12));
    }
  }

  const FrameFit& in_;
  const std::vector<double>& every_;
  std::vector<Timing>& timings_;
  std::vector<double>& frames_;
  std::vector<double> start_;
  std::vector<Linear> period_of_;
  std::vector<Linear> execution_of_;
  std::vector<Linear> frame_of_;
  Barrier barrier_;
};

}  // namespace

bool FrameFit::solve(const std::vector<double>& every, std::vector<Timing>& timings,
                     std::vector<double>& frames) const {
  return Fit(*this, every, timings, frames).solve();
}

}  // namespace ctn::planner
