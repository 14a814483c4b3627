// One core that several subchains share, under a linear objective: the best frame, exactly.
//
// Subchain i runs every n_i frames, so p_i = n_i T with the frame T = max(sum_i C_i / n_i / usable, least). The
// objective sum_i b_i p_i is then a product A(n) B(n) / usable of A = sum_i b_i n_i and B = sum_i C_i / n_i, and
//
//   min_n A B = min_t (t A + B / t)^2 / 4 = min_t (sum_i min_n (t b_i n + C_i / (t n)))^2 / 4:
//
// for a given t every subchain chooses its n by itself, whole or not. As t grows each n falls, step by step, at values
// of t that are known beforehand; walking along them visits every n that can be optimal. The optimum over whole numbers
// is therefore found in time proportional to the number of steps, not to the number of combinations. Between two steps
// free shares (queue nodes) follow a square-root law, and their part is minimised in closed form.
//
// Where the frame itself is bounded (rate caps, exact rates, bounds), the walk's best point may lie between two steps.
// Then the value is a lower bound, and the step's n is returned as a fraction for the caller to branch on.
//
// Units: milliseconds. Thread safety: one object a thread.
#pragma once

#include <cstddef>
#include <vector>

namespace ctn::planner {

// Frames that differ by no more than this part are the same.
constexpr double kSameFrame = 1e-12;

class SharedCore {
 public:
  struct Item {
    double weight = 0.0;  // b >= 0: what a millisecond of its period costs
    double cost = 0.0;    // C >= 0
    double least = 1.0;   // n in [least, most]; whole numbers unless free
    double most = 1.0;
    bool free = false;  // any n in (0, most]
  };
  struct Answer {
    bool feasible = false;
    int split = -1;             // the one item whose n is no whole number though it should be; -1: `value` can be had
    double value = 0.0;         // sum of b_i p_i, or a lower bound of it
    double frame = 0.0;         // T
    std::vector<double> every;  // n, by item
  };

  // `usable`: of the core, in (0, 1], less what exact queue nodes take. 0 <= min_frame <= max_frame. The
  // answer and the items are the object's own: valid until the next call.
  const Answer& solve(double usable, double min_frame, double max_frame);
  std::vector<Item>& items() { return items_; }

  // Steps walked since the object was made: what its work is measured in.
  std::size_t steps() const { return steps_; }

 private:
  // Of the relaxed sum of one item, as a function of t: it falls up to `low`, is `flat` up to `high`, then rises.
  struct Bend {
    double low = 0.0;
    double high = 0.0;
    double flat = 0.0;
  };

  void clear();
  bool narrow(double& from, double& to);
  double relaxed_sum(double t) const;
  void place(double at);
  void add_up();
  void walk(double from, double to);
  double step_of(std::size_t item) const;
  void between(double from, double to);
  void take(std::size_t item, double at);
  void cross(std::size_t item, double at, double more);
  void offer(double value, double frame, double root_t, int split, double every_of_split);

  std::vector<Item> items_;
  double usable_ = 1.0;
  double least_frame_ = 0.0;
  double most_frame_ = 0.0;
  bool limited_ = false;      // the frame is
  std::vector<double> now_;   // n, by item; 0 once it is free to follow t
  std::vector<double> next_;  // t squared of the next step, by item
  std::vector<Bend> bends_;
  double a_ = 0.0;     // sum of b n over the items that do not follow t
  double b_ = 0.0;     // sum of C / n over the same
  double root_ = 0.0;  // sum of sqrt(b C) over those that do
  std::size_t steps_ = 0;
  Answer answer_;
};

}  // namespace ctn::planner
