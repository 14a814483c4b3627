// Stage II, section 5.2: fractions f_i and periods p_i, with 1/f_i whole.
#include "paper/stage_two.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/numbers.h"
#include "paper/relaxation.h"

namespace ctn::paper {
namespace {

constexpr double kStageRounding = 1e-10;
// What a geometric program costs, compared with one look at a whole number.
constexpr std::size_t kProgramSteps = 1000;

// One core under prices, while whole numbers are chosen one by one: what its members add at least.
//   members with a whole number n:  price n T each, and c / (n T) of the core
//   the rest:                       (sum sqrt(price c))^2 / what is left of the core, which is least by Cauchy-Schwarz
struct OpenCore {
  double constant = 0.0;   // of exact rates, and of open numbers
  double usable = 0.0;     // without what they use
  double price = 0.0;      // of the frame: sum of price x n, and of open numbers
  double work = 0.0;       // sum of c / n
  double roots = 0.0;      // of the rest
  double open_work = 0.0;  // of the rest: sum of c / n for the largest n
  double shortest = 0.0;   // frame
  double longest = 0.0;

  double min_total() const {
    const double min_work = work + open_work;
    const double shortest_frame = std::max(shortest, min_work > 0.0 ? min_work / usable : 0.0);
    if (usable <= 0.0 && (work > 0.0 || roots > 0.0)) return kInfinity;
    if (shortest_frame > longest * (1.0 + kStageRounding)) return kInfinity;
    if (roots <= 0.0) return constant + price * (price >= 0.0 ? shortest_frame : longest);
    // The best frame for all of it, where it may be that long.
    const double best = price > 0.0 ? (work + roots * std::sqrt(work / price)) / usable : longest;
    if (price > 0.0 && best >= shortest_frame && best <= longest) {
      return constant + std::pow(std::sqrt(price * work) + roots, 2.0) / usable;
    }
    const double frame = best < shortest_frame ? shortest_frame : longest;
    const double left = usable - (work > 0.0 ? work / frame : 0.0);
    return left > 0.0 ? constant + price * frame + roots * roots / left : kInfinity;
  }
};

// Precondition: there is a shared core.
class WholeNumbers {
 public:
  WholeNumbers(const Division& division, const Goal& goal, const Relaxed& relaxed, std::size_t& steps)
      : division_(division), goal_(goal), relaxed_(relaxed), steps_(steps) {
    every_.assign(division.core_of.size(), 1);
    for (std::size_t core = 0; core < division.cores.size(); ++core) {
      begin_.push_back(begun(core));
      queues_ = queues_ || std::any_of(division.cores[core].members.begin(), division.cores[core].members.end(),
                                       [&](std::size_t i) { return division.is_free(i); });
    }
  }

  std::optional<StageTwo> run() {
    const std::size_t cores = division_.cores.size();
    rest_.assign(cores + 1, 0.0);
    for (std::size_t core = cores; core-- > 0;) rest_[core] = rest_[core + 1] + min_of(core);
    lower_bound_ = relaxed_.prices.constant + rest_.front();
    choose(0, 0, begin_[0].open, relaxed_.prices.constant);
    return found_;
  }

  double value() const { return best_; }
  double lower_bound() const { return exhaustive_ ? best_ : std::min(lower_bound_, best_); }

 private:
  struct Begun {
    OpenCore open;
    std::vector<std::size_t> whole;  // members whose number is to be chosen, exact rates first
  };

  Begun begun(std::size_t number) const {
    const SharedCore& core = division_.cores[number];
    Begun begun;
    OpenCore& open = begun.open;
    open.usable = division_.problem.usable * (1.0 + kStageRounding);
    open.longest = core.longest_frame;
    for (const std::size_t i : core.members) {
      const Subchain& subchain = division_.problem.subchains[i];
      if (division_.is_exact(i)) {
        open.constant += relaxed_.prices.of[i] * subchain.exact_period;
        open.usable -= division_.cost(i) / subchain.exact_period;
        open.shortest = std::max(open.shortest, subchain.exact_period / division_.max_every(i));
        if (!division_.is_free(i)) open.longest = std::min(open.longest, subchain.exact_period);
      } else {
        open.roots += root(i);
        open.open_work += division_.cost(i) / division_.max_every(i);
        open.constant += relaxed_.prices.open[i].constant;
        open.price += relaxed_.prices.open[i].frame;
      }
      if (!division_.is_free(i)) begun.whole.push_back(i);
    }
    const auto rank = [&](std::size_t i) {
      return division_.is_exact(i) ? std::pair(core.exact == i ? -2.0 : -1.0, 0.0)
                                   : std::pair(division_.max_every(i), -division_.cost(i));
    };
    std::stable_sort(begun.whole.begin(), begun.whole.end(),
                     [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    return begun;
  }

  double root(std::size_t i) const { return std::sqrt(relaxed_.prices.open[i].period * division_.cost(i)); }

  // The core once subchain i runs every n frames.
  OpenCore with(const OpenCore& open, std::size_t i, int n) const {
    OpenCore next = open;
    const Subchain& subchain = division_.problem.subchains[i];
    if (division_.is_exact(i)) {
      next.shortest = std::max(open.shortest, subchain.exact_period / n * (1.0 - kStageRounding));
      next.longest = std::min(open.longest, subchain.exact_period / n);
      return next;
    }
    next.constant -= relaxed_.prices.open[i].constant;
    next.price -= relaxed_.prices.open[i].frame;
    next.roots = std::max(0.0, open.roots - root(i));
    next.price += relaxed_.prices.of[i] * n;
    next.work += division_.cost(i) / n;
    next.open_work = std::max(0.0, open.open_work - division_.cost(i) / division_.max_every(i));
    next.shortest = std::max(open.shortest, subchain.min_period / n);
    return next;
  }

  // Calls visit(n, core, its least) for all n for which that least is below limit(), from the best n outwards: in log n
  // it is convex.
  template <typename Limit, typename Visit>
  void for_each(const OpenCore& open, std::size_t i, const Limit& limit, const Visit& visit) {
    const int max = static_cast<int>(division_.max_every(i));
    const auto at = [&](int n) {
      if (steps_ > 0) --steps_;
      const OpenCore next = with(open, i, n);
      return std::pair(next, next.min_total());
    };
    if (division_.is_exact(i)) {
      // It sets the frame, or has to fit it.
      for (int n = 1; n <= max && steps_ > 0; ++n) {
        const auto [next, lowest] = at(n);
        if (next.shortest <= next.longest * (1.0 + kStageRounding) && lowest < limit()) visit(n, next, lowest);
      }
      return;
    }
    int best = guess(i, max);
    auto found = at(best);
    for (const int side : {-1, 1}) {
      while (best + side >= 1 && best + side <= max) {
        auto next = at(best + side);
        // Where nothing is possible yet, more frames a run leave more of the core.
        if (!(next.second < found.second) && !(side > 0 && !std::isfinite(next.second) && !std::isfinite(found.second)))
          break;
        best += side;
        found = std::move(next);
      }
    }
    if (found.second < limit()) visit(best, found.first, found.second);
    int low = best - 1;
    int high = best + 1;
    bool down = low >= 1;
    bool up = high <= max;
    while ((down || up) && steps_ > 0) {
      if (down) {
        const auto [next, lowest] = at(low);
        down = lowest < limit();
        if (down) visit(low, next, lowest);
        down = down && --low >= 1;
      }
      if (up) {
        const auto [next, lowest] = at(high);
        up = lowest < limit();
        if (up) visit(high, next, lowest);
        up = up && ++high <= max;
      }
    }
  }

  int guess(std::size_t i, int max) const {
    const double frame = relaxed_.frames[static_cast<std::size_t>(division_.core_of[i])];
    const double every = frame > 0.0 ? relaxed_.periods[i] / frame : 1.0;
    return static_cast<int>(std::clamp(std::round(every), 1.0, static_cast<double>(max)));
  }

  // The least of a core by itself, with whole numbers. Where it takes too long, without.
  double min_of(std::size_t number) {
    const Begun& begin = begin_[number];
    double best = kInfinity;
    constexpr std::size_t kShare = 10;
    const std::size_t before = steps_;
    const std::size_t max = steps_ / kShare / division_.cores.size();
    const auto takes_too_long = [&] { return steps_ == 0 || before - steps_ > max; };
    const auto descend = [&](const auto& self, std::size_t at, const OpenCore& open, double lowest) -> void {
      if (takes_too_long()) return;
      if (at == begin.whole.size()) {
        best = std::min(best, lowest);
        return;
      }
      for_each(
          open, begin.whole[at], [&] { return best; },
          [&](int, const OpenCore& next, double next_min) { self(self, at + 1, next, next_min); });
    };
    descend(descend, 0, begin.open, begin.open.min_total());
    return takes_too_long() ? begin.open.min_total() : best;
  }

  void choose(std::size_t core, std::size_t at, const OpenCore& open, double before) {
    if (at == begin_[core].whole.size()) {
      frames_.push_back(open);
      const double so_far = before + open.min_total();
      if (core + 1 == begin_.size()) {
        judge();
      } else {
        choose(core + 1, 0, begin_[core + 1].open, so_far);
      }
      frames_.pop_back();
      return;
    }
    const std::size_t i = begin_[core].whole[at];
    for_each(
        open, i, [&] { return to_beat() - before - rest_[core + 1]; },
        [&](int n, const OpenCore& next, double) {
          every_[i] = n;
          choose(core, at + 1, next, before);
        });
    if (steps_ == 0) exhaustive_ = false;
  }

  double to_beat() const { return std::isfinite(best_) ? best_ - kStageRounding * std::abs(best_) : kInfinity; }

  // All numbers are whole: frames, periods, and what they come to.
  void judge() {
    StageTwo found;
    found.timings = division_.timings;
    std::optional<Relaxed> free;
    if (queues_) {
      steps_ -= std::min(steps_, kProgramSteps);
      free = relax(division_, goal_, every_);
      if (!free) return;
    }
    for (std::size_t core = 0; core < division_.cores.size(); ++core) {
      set(core, free ? &*free : nullptr, found);
    }
    const double factor = factor_of(division_.problem.bounds, found.timings);
    if (!goal_.minimise_factor && factor > goal_.factor * (1.0 + kStageRounding)) return;
    const double value = goal_.minimise_factor ? factor : objective_of(division_.problem.terms, found.timings);
    if (!(value < best_)) return;
    best_ = value;
    found_ = std::move(found);
  }

  void set(std::size_t number, const Relaxed* free, StageTwo& found) const {
    const SharedCore& core = division_.cores[number];
    const OpenCore& open = frames_[number];
    const bool has_free = std::any_of(core.members.begin(), core.members.end(),
                                      [&](std::size_t i) { return division_.is_free(i) && !division_.is_exact(i); });
    double frame = std::max(open.shortest, open.usable > 0.0 ? open.work / open.usable : 0.0);
    if (has_free) frame = std::max(frame, free->frames[number]);
    if (core.exact) frame = division_.problem.subchains[*core.exact].exact_period / every_[*core.exact];
    double wanted = 0.0;
    for (const std::size_t i : core.members) {
      const Subchain& subchain = division_.problem.subchains[i];
      double period = frame * every_[i];
      if (division_.is_exact(i)) {
        period = subchain.exact_period;
      } else if (division_.is_free(i)) {
        period = free->periods[i];
        wanted += division_.cost(i) / period;
      }
      found.timings[i] = {period, period};
    }
    // What the interior-point method leaves of the core is theirs.
    const double left = frame > 0.0 ? open.usable - open.work / frame : open.usable;
    for (const std::size_t i : core.members) {
      if (!division_.is_free(i) || division_.is_exact(i) || !(left > 0.0)) continue;
      const double min = std::max(division_.problem.subchains[i].min_period, 0.0);
      double& period = found.timings[i].period;
      period = std::max(period * wanted / left, min);
      found.timings[i].execution = period;
    }
    found.frames.push_back(frame);
  }

  const Division& division_;
  const Goal& goal_;
  const Relaxed& relaxed_;
  std::size_t& steps_;
  std::vector<Begun> begin_;  // by core
  bool queues_ = false;       // there are free numbers
  std::vector<double> rest_;  // what the cores from one on add at least
  std::vector<int> every_;
  std::vector<OpenCore> frames_;  // of the cores that are done
  double best_ = kInfinity;
  double lower_bound_ = -kInfinity;
  bool exhaustive_ = true;
  std::optional<StageTwo> found_;
};

struct Answer {
  StageTwo stage;
  double value = 0.0;
  double lower_bound = 0.0;
};

std::optional<Answer> minimise(const Division& division, const Goal& goal, const Relaxed& relaxed, std::size_t& steps) {
  WholeNumbers search(division, goal, relaxed, steps);
  std::optional<StageTwo> found = search.run();
  if (!found) return std::nullopt;
  return Answer{*std::move(found), search.value(), search.lower_bound()};
}

double gap_of(double value, double lower_bound) {
  const double gap = value > 0.0 ? std::max(0.0, 1.0 - std::max(0.0, lower_bound) / value) : 0.0;
  return gap <= 1e-9 ? 0.0 : gap;
}

bool keeps_exact_rates(const Division& division) {
  for (std::size_t i = 0; i < division.core_of.size(); ++i) {
    if (division.core_of[i] < 0 && division.is_exact(i) &&
        division.timings[i].period > division.problem.subchains[i].exact_period * (1.0 + kStageRounding)) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::optional<StageTwo> divide_cores(const Problem& problem, const Allocation& allocation, std::size_t steps) {
  const Division division = divide(problem, allocation);
  if (!keeps_exact_rates(division)) return std::nullopt;
  if (division.cores.empty()) return StageTwo{division.timings, {}, 0.0};
  const Goal free{false, kInfinity};
  const std::optional<Relaxed> relaxed = relax(division, free, {});
  if (!relaxed) return std::nullopt;
  std::size_t left = steps;
  std::optional<Answer> best = minimise(division, free, *relaxed, left);
  if (!best) return std::nullopt;
  best->stage.gap = gap_of(best->value, best->lower_bound);
  if (factor_of(problem.bounds, best->stage.timings) <= 1.0 + kStageRounding) return best->stage;

  // Not all bounds hold.
  const double lower_bound = best->lower_bound;
  const Goal nearest{true, kInfinity};
  const std::optional<Relaxed> towards = relax(division, nearest, {});
  if (!towards) return best->stage;
  left = steps;
  std::optional<Answer> min_factor = minimise(division, nearest, *towards, left);
  if (!min_factor) return best->stage;
  constexpr double kUnscaled = 1.0 + 1e-9;
  const Goal within{false, std::max(1.0, min_factor->value) * kUnscaled};
  const std::optional<Relaxed> tight = relax(division, within, {});
  left = steps;
  std::optional<Answer> answer = minimise(division, within, tight ? *tight : *relaxed, left);
  StageTwo& stage = answer ? answer->stage : min_factor->stage;
  stage.gap = gap_of(objective_of(problem.terms, stage.timings),
                     answer ? std::max(lower_bound, answer->lower_bound) : lower_bound);
  if (min_factor->lower_bound < min_factor->value * (1.0 - kStageRounding)) stage.gap = 1.0;
  return stage;
}

}  // namespace ctn::paper
