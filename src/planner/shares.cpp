#include "planner/shares.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "planner/frame_fit.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;
// Bounds and exact rates hold if they are missed by no more than this part.
constexpr double kMet = 1e-10;
// No frame is longer than so many times one run of everything on its core: subchains that no term weighs would
// otherwise be put off without end.
constexpr double kLongestFrame = 100.0;
constexpr int kRounds = 80;         // of adjusting multipliers, at most
constexpr int kRoundsTogether = 4;  // after so many the gap must have shrunk
constexpr std::size_t kFitEffort = 100;

// The nearest point, by distance, whose coordinates are >= 0 and sum to `sum`.
void project_on_simplex(double* values, std::size_t count, double sum, std::vector<double>& scratch) {
  scratch.assign(values, values + count);
  std::sort(scratch.begin(), scratch.end(), std::greater<>());
  double total = 0.0;
  double shift = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    total += scratch[i];
    const double candidate = (total - sum) / static_cast<double>(i + 1);
    if (scratch[i] > candidate) shift = candidate;
  }
  double left = 0.0;
  for (std::size_t i = 0; i < count; ++i) left += values[i] = std::max(0.0, values[i] - shift);
  // The sum is what makes a bound valid, so it is not left to rounding.
  const bool lost = !(left > 0.0) || !std::isfinite(left);
  for (std::size_t i = 0; i < count; ++i) values[i] = lost ? sum / static_cast<double>(count) : values[i] / left * sum;
}

bool whole(const Member& member) { return !member.queue; }

// Queue nodes with an exact rate take a known part of the core and have nothing left to decide.
bool set_apart(const Member& member) { return member.queue && member.exact_period > 0.0; }

double capped_at(const Member& member) { return std::max(member.least_period, member.exact_period); }

}  // namespace

Target objective_target(const Instance& instance, double factor) {
  Target target{instance.objective, instance.bounds};
  for (Group& limit : target.limits) limit.limit *= factor;
  return target;
}

Target free_target(const Instance& instance) { return {instance.objective, {}}; }

Target factor_target(const Instance& instance) {
  Group factor{1.0, 0.0, {Form{1.0, {}}}};
  for (const Group& bound : instance.bounds) {
    for (Form form : bound.forms) {
      form.constant /= bound.limit;
      for (Coefficient& c : form.coefficients) {
        c.period /= bound.limit;
        c.execution /= bound.limit;
      }
      factor.forms.push_back(std::move(form));
    }
  }
  return {{std::move(factor)}, {}};
}

SharesSolver::SharesSolver(const Instance& instance, const Target& target) : instance_(instance), target_(target) {
  contested_ = !target.limits.empty();
  for (const Group& group : target.groups) {
    offsets_.push_back(multipliers_.size());
    const double even = group.weight / static_cast<double>(group.forms.size());
    multipliers_.insert(multipliers_.end(), group.forms.size(), even);
    contested_ = contested_ || group.forms.size() > 1;
  }
  for (const Group& limit : target.limits) {
    offsets_.push_back(multipliers_.size());
    multipliers_.insert(multipliers_.end(), limit.forms.size(), 0.0);
  }
  offsets_.push_back(multipliers_.size());
  for (const Member& member : instance.members) {
    multipliers_.push_back(0.0);
    contested_ = contested_ || (!set_apart(member) && capped_at(member) > 0.0);
  }
  steepness_.resize(multipliers_.size());
  cap_price_.resize(instance.members.size());
  full_.least.assign(instance.members.size(), 1.0);
  full_.most.resize(instance.members.size());
  cost_.resize(instance.members.size());
  for (std::size_t i = 0; i < instance.members.size(); ++i) place(i, 0);
}

// What a subchain costs, and how often it may run at most, follow from the kind of its cores.
void SharesSolver::place(std::size_t i, int kind) {
  const OnKind& on = instance_.members[i].on_kind(kind);
  cost_[i] = on.cost;
  full_.most[i] = on.most_every;
}

const Owned& SharesSolver::owned(std::size_t i, const Allocation& allocation) const {
  const OnKind& on = instance_.members[i].on_kind(allocation.kind[i]);
  return on.owned[static_cast<std::size_t>(allocation.owned[i] - 1)];
}

// ---- The Lagrangian

void SharesSolver::price() {
  const std::size_t count = instance_.members.size();
  prices_.period.assign(count, 0.0);
  prices_.execution.assign(count, 0.0);
  prices_.constant = 0.0;
  const auto add = [&](const Form& form, double multiplier) {
    if (multiplier == 0.0) return;
    prices_.constant += multiplier * form.constant;
    for (const Coefficient& c : form.coefficients) {
      prices_.period[static_cast<std::size_t>(c.subchain)] += multiplier * c.period;
      prices_.execution[static_cast<std::size_t>(c.subchain)] += multiplier * c.execution;
    }
  };
  for (std::size_t g = 0; g < target_.groups.size(); ++g) {
    for (std::size_t e = 0; e < target_.groups[g].forms.size(); ++e) {
      add(target_.groups[g].forms[e], multipliers_[offsets_[g] + e]);
    }
  }
  for (std::size_t c = 0; c < target_.limits.size(); ++c) {
    for (std::size_t e = 0; e < target_.limits[c].forms.size(); ++e) {
      const double multiplier = multipliers_[offsets_[target_.groups.size() + c] + e];
      add(target_.limits[c].forms[e], multiplier);
      prices_.constant -= multiplier * target_.limits[c].limit;
    }
  }
}

const SharesSolver::Prices& SharesSolver::prices() {
  price();
  return prices_;
}

// The frames that rate caps, exact rates and the box leave. False: none.
bool SharesSolver::limit_frames(const Box& box) {
  for (std::size_t core = 0; core < members_.size(); ++core) {
    double least = 0.0;
    double usable = instance_.usable;
    double longest = kInfinity;
    double total = 0.0;
    double slowest = 0.0;
    bool any_item = false;
    for (const int index : members_[core]) {
      const auto i = static_cast<std::size_t>(index);
      const Member& member = instance_.members[i];
      total += cost_[i];
      slowest = std::max({slowest, member.least_period, member.exact_period});
      if (set_apart(member)) {
        usable -= cost_[i] / member.exact_period;
        least = std::max(least, member.exact_period / full_.most[i]);
        continue;
      }
      any_item = true;
      if (member.exact_period > 0.0) {
        least = std::max(least, member.exact_period / box.most[i]);
        longest = std::min(longest, member.exact_period / box.least[i]);
      } else {
        least = std::max(least, member.least_period / box.most[i]);
      }
    }
    if (!any_item) least = std::max(least, slowest);
    if (!(usable > 0.0)) return false;
    least_frame_[core] = least;
    usable_[core] = usable;
    most_frame_[core] = std::min(longest, std::max({kLongestFrame * total / usable, slowest, least}));
    if (least > most_frame_[core] * (1.0 + kRounding)) return false;
  }
  return true;
}

// What a rate cap is worth to each member of a core: with p >= r beside sum of C / p <= usable, the least of the
// weighted sum is at p = max(r, sqrt(C / b) / v) for one v, and the price that makes a capped member content with r is
// b - v^2 C / r^2. It depends on who shares the core. Where that is given, it is what the subgradient steps begin with.
void SharesSolver::price_caps(const std::vector<int>& members, double usable) {
  double room = usable;
  double roots = 0.0;
  bool any = false;
  for (const int index : members) {
    const auto i = static_cast<std::size_t>(index);
    const Member& member = instance_.members[i];
    cap_price_[i] = 0.0;
    if (set_apart(member)) continue;
    roots += std::sqrt(weight(i) * cost_[i]);
    any = any || capped_at(member) > 0.0;
  }
  if (!any) return;
  double v = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    v = roots > 1e-300 ? room / roots : std::numeric_limits<double>::infinity();
    for (const int index : members) {
      const auto i = static_cast<std::size_t>(index);
      const Member& member = instance_.members[i];
      const double cap = capped_at(member);
      if (cap <= 0.0 || cap_price_[i] > 0.0 || set_apart(member) || weight(i) <= 0.0) continue;
      if (!(std::sqrt(cost_[i] / weight(i)) < cap * v)) continue;
      cap_price_[i] = 1.0;  // capped; its price follows
      room -= cost_[i] / cap;
      roots -= std::sqrt(weight(i) * cost_[i]);
      changed = true;
    }
    if (room <= 0.0) break;
  }
  for (const int index : members) {
    const auto i = static_cast<std::size_t>(index);
    if (cap_price_[i] == 0.0) continue;
    const Member& member = instance_.members[i];
    const double cap = capped_at(member);
    // Rounding may leave a hair of the roots of what is all capped.
    const bool all = roots <= 1e-12 * weight(i) * cap;
    const double price = room <= 0.0 ? 0.0 : all ? weight(i) : weight(i) - v * v * cost_[i] / (cap * cap);
    cap_price_[i] = std::clamp(price, 0.0, weight(i));
  }
}

// The least that the members of a core cost under the present prices; infinite where no frame will do.
double SharesSolver::solve_core(const std::vector<int>& members, std::size_t core, const Box& box) {
  double value = 0.0;
  std::vector<SharedCore::Item>& items = core_.items();
  items.clear();
  for (const int index : members) {
    const auto i = static_cast<std::size_t>(index);
    const Member& member = instance_.members[i];
    if (set_apart(member)) {
      value += weight(i) * member.exact_period;
      continue;
    }
    value += cap_price_[i] * capped_at(member);
    items.push_back({weight(i) - cap_price_[i], cost_[i], box.least[i], box.most[i], member.queue});
  }
  const SharedCore::Answer& answer = core_.solve(usable_[core], least_frame_[core], most_frame_[core]);
  answer_ = &answer;
  return answer.feasible ? value + answer.value : kInfinity;
}

// Minimises the Lagrangian: point_.
void SharesSolver::relax(const Allocation& allocation, const Box& box) {
  price();
  const std::size_t count = instance_.members.size();
  const double* caps = multipliers_.data() + offsets_.back();
  for (std::size_t i = 0; i < count; ++i) cap_price_[i] = std::min(caps[i], weight(i));
  point_.feasible = false;
  point_.split.clear();
  point_.value = prices_.constant;
  for (std::size_t i = 0; i < count; ++i) {
    if (shared(i, allocation)) continue;
    const Owned& alone = owned(i, allocation);
    point_.timings[i] = {alone.period, alone.execution};
    point_.value += prices_.period[i] * alone.period + prices_.execution[i] * alone.execution;
  }
  for (std::size_t core = 0; core < static_cast<std::size_t>(allocation.shared_cores); ++core) {
    point_.value += solve_core(members_[core], core, box);
    if (!std::isfinite(point_.value)) return;
    point_.frames[core] = answer_->frame;
    int position = 0;
    for (const int index : members_[core]) {
      const auto i = static_cast<std::size_t>(index);
      const Member& member = instance_.members[i];
      if (set_apart(member)) {
        point_.timings[i] = {member.exact_period, member.exact_period};
        point_.every[i] = member.exact_period / answer_->frame;
        continue;
      }
      if (position == answer_->split) point_.split.push_back(index);
      point_.every[i] = answer_->every[static_cast<std::size_t>(position++)];
      point_.timings[i].period = point_.timings[i].execution = point_.every[i] * answer_->frame;
    }
  }
  point_.feasible = true;
}

// A subgradient step of Polyak's length towards `goal`. False where there is nowhere to go.
bool SharesSolver::adjust(double goal, double level) {
  double norm = 0.0;
  const std::size_t groups = target_.groups.size();
  for (std::size_t g = 0; g < groups; ++g) {
    const std::vector<Form>& forms = target_.groups[g].forms;
    double* slope = steepness_.data() + offsets_[g];
    const double* multiplier = multipliers_.data() + offsets_[g];
    if (forms.size() < 2 || target_.groups[g].weight <= 0.0) {
      std::fill(slope, slope + forms.size(), 0.0);
      continue;
    }
    double mean = 0.0;
    for (std::size_t e = 0; e < forms.size(); ++e) {
      slope[e] = value_of(forms[e], point_.timings);
      mean += multiplier[e] * slope[e];
    }
    mean /= target_.groups[g].weight;
    for (std::size_t e = 0; e < forms.size(); ++e) {
      slope[e] -= mean;
      if (multiplier[e] > 0.0 || slope[e] > 0.0) norm += slope[e] * slope[e];
    }
  }
  for (std::size_t c = 0; c < target_.limits.size(); ++c) {
    const std::size_t at = offsets_[groups + c];
    for (std::size_t e = 0; e < target_.limits[c].forms.size(); ++e) {
      const double over = value_of(target_.limits[c].forms[e], point_.timings) - target_.limits[c].limit;
      steepness_[at + e] = over;
      if (multipliers_[at + e] > 0.0 || over > 0.0) norm += over * over;
    }
  }
  const std::size_t caps = offsets_.back();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    const Member& member = instance_.members[i];
    const double cap = set_apart(member) ? 0.0 : capped_at(member);
    const double under = cap > 0.0 ? cap - point_.timings[i].period : 0.0;
    steepness_[caps + i] = under;
    if (multipliers_[caps + i] > 0.0 || under > 0.0) norm += under * under;
  }
  const double gain = goal - level;
  if (!(norm > 0.0) || !(gain > 0.0) || !std::isfinite(gain)) return false;
  const double step = gain / norm;
  for (std::size_t g = 0; g < groups; ++g) {
    const std::size_t forms = target_.groups[g].forms.size();
    if (forms < 2 || target_.groups[g].weight <= 0.0) continue;
    double* multiplier = multipliers_.data() + offsets_[g];
    for (std::size_t e = 0; e < forms; ++e) multiplier[e] += step * steepness_[offsets_[g] + e];
    project_on_simplex(multiplier, forms, target_.groups[g].weight, scratch_);
  }
  for (std::size_t m = offsets_[groups]; m < multipliers_.size(); ++m) {
    multipliers_[m] = std::max(0.0, multipliers_[m] + step * steepness_[m]);
  }
  // A price beyond the period's own would make it worth less than nothing.
  price();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    multipliers_[caps + i] = std::min(multipliers_[caps + i], weight(i));
  }
  return true;
}

// The caps' prices to begin with, where an allocation is given.
void SharesSolver::start_caps() {
  price();
  std::fill(cap_price_.begin(), cap_price_.end(), 0.0);
  for (std::size_t core = 0; core < members_.size(); ++core) price_caps(members_[core], usable_[core]);
  std::copy(cap_price_.begin(), cap_price_.end(), multipliers_.begin() + static_cast<std::ptrdiff_t>(offsets_.back()));
}

// The best bound that some rounds of adjusting find; multipliers_ are then those of it. Considers every point on the
// way as a solution. Infinite where nothing is feasible.
double SharesSolver::climb(const Allocation& allocation, const Box& box) {
  double best = -kInfinity;
  std::vector<double> at_best = multipliers_;
  Point best_point;
  double patience = 1.0;
  double gap_before = kInfinity;
  for (int round = 0; round < kRounds; ++round) {
    relax(allocation, box);
    ++rounds_;
    if (!point_.feasible) return kInfinity;
    if (point_.value > best) {
      best = point_.value;
      at_best = multipliers_;
      best_point = point_;
    } else {
      patience *= 0.6;
      if (patience < 0.05) break;
    }
    consider(allocation);
    if (best >= proof_of(known())) break;
    if (!contested_) break;
    if (round % kRoundsTogether == kRoundsTogether - 1) {
      const double gap = known() - best;
      if (gap > 0.5 * gap_before) break;
      gap_before = gap;
    }
    double aim = std::isfinite(known()) ? known() : 0.0;
    if (!(aim > point_.value)) aim = point_.value + 0.05 * std::abs(point_.value);
    if (!adjust(point_.value + patience * (aim - point_.value), point_.value)) break;
  }
  multipliers_ = at_best;
  point_ = std::move(best_point);
  return best;
}

// ---- Solutions

// The frame and the timings of a core's subchains for whole numbers n; free shares as in point_, scaled to fill the
// core.
bool SharesSolver::fit_core(int core, const std::vector<double>& every, std::vector<Timing>& timings,
                            double& frame) const {
  const auto k = static_cast<std::size_t>(core);
  double busy = 0.0;
  double least = 0.0;
  double exact = 0.0;
  bool free = false;
  for (const int index : members_[k]) {
    const auto i = static_cast<std::size_t>(index);
    const Member& member = instance_.members[i];
    if (member.queue) {
      if (member.exact_period > 0.0) {
        least = std::max(least, member.exact_period / full_.most[i]);
      } else {
        free = true;
      }
      continue;
    }
    busy += cost_[i] / every[i];
    least = std::max(least, member.least_period / every[i]);
    if (member.exact_period > 0.0) {
      const double given = member.exact_period / every[i];
      if (exact > 0.0 && std::abs(given - exact) > kMet * exact) return false;
      exact = std::max(exact, given);
    }
  }
  frame = free ? std::max({point_.frames[k], busy / usable_[k] * (1.0 + kRounding), least})
               : std::max({busy / usable_[k], least, least_frame_[k]});
  if (exact > 0.0) {
    if (std::max(free ? 0.0 : busy / usable_[k], least) > exact * (1.0 + kMet)) return false;
    frame = exact;
  }
  double wanted = 0.0;
  for (const int index : members_[k]) {
    const auto i = static_cast<std::size_t>(index);
    const Member& member = instance_.members[i];
    double period = every[i] * frame;
    if (member.queue) {
      period =
          member.exact_period > 0.0 ? member.exact_period : std::max(every[i] * point_.frames[k], member.least_period);
      if (member.exact_period == 0.0) wanted += cost_[i] / period;
    } else if (member.exact_period > 0.0) {
      period = member.exact_period;
    }
    timings[i] = {period, period};
  }
  const double room = usable_[k] - busy / frame;
  if (!free) return true;
  if (wanted <= 0.0) return room >= -kMet * usable_[k];
  if (!(room > 0.0)) return false;
  const double scale = wanted / room;
  for (const int index : members_[k]) {
    const auto i = static_cast<std::size_t>(index);
    const Member& member = instance_.members[i];
    if (!member.queue || member.exact_period > 0.0) continue;
    double period = timings[i].period;
    period = scale > 1.0 ? period * scale : std::max(period * scale, member.least_period);
    if (period > full_.most[i] * frame * (1.0 + kRounding)) return false;
    timings[i] = {period, period};
  }
  return true;
}

void SharesSolver::consider_every(const Allocation& allocation, const std::vector<double>& every) {
  std::vector<Timing> timings = point_.timings;
  std::vector<double> frames(static_cast<std::size_t>(allocation.shared_cores));
  for (int core = 0; core < allocation.shared_cores; ++core) {
    if (!fit_core(core, every, timings, frames[static_cast<std::size_t>(core)])) return;
  }
  keep(timings, frames);
}

// Every n that is split is rounded down or up: in all ways where there are few of them, else all alike.
void SharesSolver::consider(const Allocation& allocation) {
  constexpr std::size_t kFew = 3;
  const std::size_t splits = point_.split.size();
  std::vector<double> every = point_.every;
  const std::size_t ways = splits <= kFew ? std::size_t{1} << splits : 2;
  for (std::size_t way = 0; way < ways; ++way) {
    for (std::size_t s = 0; s < splits; ++s) {
      const auto i = static_cast<std::size_t>(point_.split[s]);
      const bool up = splits <= kFew ? (way >> s & 1U) != 0 : way == 1;
      every[i] = up ? std::ceil(point_.every[i]) : std::floor(point_.every[i]);
    }
    consider_every(allocation, every);
  }
}

void SharesSolver::keep(const std::vector<Timing>& timings, const std::vector<double>& frames) {
  const double value = weighted_sum(target_.groups, timings);
  if (!(value < best_.value)) return;
  for (const Group& limit : target_.limits) {
    if (value_of(limit, timings) > limit.limit * (1.0 + kMet)) return;
  }
  best_.found = true;
  best_.value = value;
  best_.timings = timings;
  best_.frames = frames;
}

// ---- Branching

// Even the shortest periods that the box leaves break a limit.
bool SharesSolver::hopeless(const Box& box) {
  if (target_.limits.empty()) return false;
  std::vector<Timing> shortest = point_.timings;
  for (std::size_t core = 0; core < members_.size(); ++core) {
    double busy = 0.0;
    for (const int index : members_[core]) {
      const auto i = static_cast<std::size_t>(index);
      if (whole(instance_.members[i])) busy += cost_[i] / box.most[i];
    }
    const double frame = std::max(least_frame_[core], busy / usable_[core]);
    for (const int index : members_[core]) {
      const auto i = static_cast<std::size_t>(index);
      const Member& member = instance_.members[i];
      double period = std::max(cost_[i] / usable_[core], member.least_period);
      if (whole(member)) period = std::max(period, box.least[i] * frame);
      if (member.exact_period > 0.0) period = member.exact_period;
      shortest[i] = {period, period};
    }
  }
  return std::any_of(target_.limits.begin(), target_.limits.end(),
                     [&](const Group& limit) { return value_of(limit, shortest) > limit.limit * (1.0 + kMet); });
}

// Where two periods contend for the longest of a chain, the n of one is divided where they meet: on either side the
// contest is decided. Else the n that is least certain. -1: all n of the group are fixed.
int SharesSolver::divide_group(const Box& box, const Group& group, const double* multiplier, double& at) const {
  const auto open = [&](int subchain) {
    const auto i = static_cast<std::size_t>(subchain);
    return whole(instance_.members[i]) && box.most[i] > box.least[i] && point_.timings[i].period > 0.0 &&
           point_.every[i] > 0.0;
  };
  std::size_t top = 0;
  std::size_t rival = group.forms.size();
  for (std::size_t e = 1; e < group.forms.size(); ++e) {
    if (value_of(group.forms[e], point_.timings) > value_of(group.forms[top], point_.timings)) top = e;
  }
  for (std::size_t e = 0; e < group.forms.size(); ++e) {
    if (e != top && multiplier[e] > 0.0 && (rival == group.forms.size() || multiplier[e] > multiplier[rival]))
      rival = e;
  }
  if (rival < group.forms.size()) {
    const double surplus = value_of(group.forms[top], point_.timings) - value_of(group.forms[rival], point_.timings);
    const auto meet = [&](std::size_t of, std::size_t beside, double change) {
      for (const Coefficient& c : group.forms[of].coefficients) {
        if (!open(c.subchain)) continue;
        double coefficient = c.period;
        for (const Coefficient& other : group.forms[beside].coefficients) {
          if (other.subchain == c.subchain) coefficient -= other.period;
        }
        if (!(coefficient > 0.0)) continue;
        const auto i = static_cast<std::size_t>(c.subchain);
        const double n = point_.every[i] * (1.0 + change / coefficient / point_.timings[i].period);
        if (n < box.least[i] || n >= box.most[i]) continue;
        at = std::floor(n);
        return c.subchain;
      }
      return -1;
    };
    const int of_top = meet(top, rival, -surplus);
    if (of_top >= 0) return of_top;
    const int of_rival = meet(rival, top, surplus);
    if (of_rival >= 0) return of_rival;
  }
  int widest = -1;
  double width = 0.0;
  for (const Form& form : group.forms) {
    for (const Coefficient& c : form.coefficients) {
      if (!open(c.subchain)) continue;
      const auto i = static_cast<std::size_t>(c.subchain);
      const double relative = (box.most[i] - box.least[i]) / point_.every[i];
      if (relative <= width) continue;
      width = relative;
      widest = c.subchain;
      const double n = point_.every[i] < box.most[i] ? point_.every[i] : point_.every[i] - 1.0;
      at = std::clamp(std::floor(n), box.least[i], box.most[i] - 1.0);
    }
  }
  return widest;
}

// Which subchain's n to divide, and at what: [least, at] and [at + 1, most]. -1: all are fixed.
int SharesSolver::branch_on(const Box& box, double& at) const {
  const auto divide = [&](std::size_t i, double n) {
    at = std::clamp(std::floor(n), box.least[i], box.most[i] - 1.0);
    return static_cast<int>(i);
  };
  const auto open = [&](std::size_t i) { return whole(instance_.members[i]) && box.most[i] > box.least[i]; };
  for (const int split : point_.split) {
    const auto i = static_cast<std::size_t>(split);
    if (open(i)) return divide(i, point_.every[i]);
  }
  int chosen = -1;
  double worst = 0.0;
  for (const std::vector<int>& members : members_) {
    for (const int index : members) {
      const auto i = static_cast<std::size_t>(index);
      const Member& member = instance_.members[i];
      if (!open(i)) continue;
      const double period = point_.timings[i].period;
      double miss = 0.0;
      if (member.exact_period > 0.0) {
        miss = std::abs(period - member.exact_period) / member.exact_period;
        if (miss > worst && miss > kMet) {
          worst = miss;
          chosen = divide(i, period < member.exact_period ? point_.every[i] : point_.every[i] - 1.0);
        }
      } else if (period < member.least_period * (1.0 - kMet)) {
        miss = (member.least_period - period) / member.least_period;
        if (miss > worst) {
          worst = miss;
          chosen = divide(i, point_.every[i]);
        }
      }
    }
  }
  if (chosen >= 0) return chosen;
  // What the multipliers reckon a maximum to be, beside what it is.
  const std::size_t groups = target_.groups.size();
  for (std::size_t g = 0; g < groups + target_.limits.size(); ++g) {
    const bool limit = g >= groups;
    const Group& group = limit ? target_.limits[g - groups] : target_.groups[g];
    const double* multiplier = multipliers_.data() + offsets_[g];
    double loss = 0.0;
    if (limit) {
      loss = std::abs(value_of(group, point_.timings) - group.limit) / group.limit * std::abs(point_.value);
    } else if (group.forms.size() > 1) {
      double reckoned = 0.0;
      for (std::size_t e = 0; e < group.forms.size(); ++e) {
        reckoned += multiplier[e] * value_of(group.forms[e], point_.timings);
      }
      loss = group.weight * value_of(group, point_.timings) - reckoned;
    }
    if (!(loss > worst)) continue;
    double where = 0.0;
    const int i = divide_group(box, group, multiplier, where);
    if (i < 0) continue;
    worst = loss;
    chosen = i;
    at = where;
  }
  if (chosen >= 0) return chosen;
  double width = 0.0;
  for (const std::vector<int>& members : members_) {
    for (const int index : members) {
      const auto i = static_cast<std::size_t>(index);
      if (!open(i)) continue;
      const double relative = (box.most[i] - box.least[i]) / box.least[i];
      if (relative <= width) continue;
      width = relative;
      chosen = divide(i, std::sqrt(box.least[i] * box.most[i]));
    }
  }
  return chosen;
}

void SharesSolver::finish_leaf(const Allocation& allocation, const Box& box) {
  std::vector<double> every = point_.every;
  bool free = false;
  for (const std::vector<int>& members : members_) {
    for (const int index : members) {
      const auto i = static_cast<std::size_t>(index);
      if (whole(instance_.members[i])) every[i] = box.least[i];
      free = free || (instance_.members[i].queue && instance_.members[i].exact_period == 0.0);
    }
  }
  consider_every(allocation, every);
  if (!free || !contested_) return;
  FrameFit fit{instance_, target_, members_, cost_, full_.most, usable_, least_frame_, most_frame_};
  std::vector<Timing> timings = point_.timings;
  std::vector<double> frames = point_.frames;
  if (fit.solve(every, timings, frames)) keep(timings, frames);
}

void SharesSolver::explore(const Allocation& allocation, Node node, std::vector<Node>& open, Effort& effort) {
  const std::size_t before = core_.steps();
  rounds_ = 0;
  multipliers_ = std::move(node.multipliers);
  double bound = kInfinity;
  const bool root = node.bound == -kInfinity;
  if (limit_frames(node.box) && !hopeless(node.box)) {
    if (root) start_caps();
    bound = climb(allocation, node.box);
  }
  effort.spend(1 + rounds_ + (core_.steps() - before) / 16);
  if (bound == kInfinity || bound >= proof_of(known())) return;
  double at = 0.0;
  const int chosen = branch_on(node.box, at);
  if (chosen < 0) {
    effort.spend(kFitEffort);
    return finish_leaf(allocation, node.box);
  }
  const auto i = static_cast<std::size_t>(chosen);
  node.bound = std::max(node.bound, bound);
  node.multipliers = multipliers_;
  Node lower = node;
  lower.box.most[i] = at;
  node.box.least[i] = at + 1.0;
  // The half that the point is in is looked at first.
  if (point_.every[i] <= at) std::swap(lower, node);
  open.push_back(std::move(lower));
  open.push_back(std::move(node));
}

void SharesSolver::prepare(const Allocation& allocation) {
  const std::size_t count = instance_.members.size();
  const auto cores = static_cast<std::size_t>(allocation.shared_cores);
  members_.assign(cores, {});
  for (std::size_t i = 0; i < count; ++i) {
    place(i, allocation.kind[i]);
    if (shared(i, allocation)) members_[static_cast<std::size_t>(allocation.core_of[i])].push_back(static_cast<int>(i));
  }
  least_frame_.resize(cores);
  most_frame_.resize(cores);
  usable_.resize(cores);
  point_.timings.assign(count, {});
  point_.every.assign(count, 1.0);
  point_.frames.assign(cores, 0.0);
}

Shares SharesSolver::solve(const Allocation& allocation, double cutoff, Effort& effort) {
  prepare(allocation);
  best_ = {};
  cutoff_ = cutoff;
  std::vector<Node> open;
  explore(allocation, {full_, multipliers_, -kInfinity}, open, effort);
  const std::vector<double> at_root = multipliers_;
  while (!open.empty() && effort.left > 0) {
    Node node = std::move(open.back());
    open.pop_back();
    if (node.bound >= proof_of(known())) continue;
    explore(allocation, std::move(node), open, effort);
  }
  multipliers_ = at_root;
  best_.bound = std::min(best_.value, cutoff);
  for (const Node& node : open) best_.bound = std::min(best_.bound, node.bound);
  return std::move(best_);
}

double SharesSolver::price_of_owned(int subchain, int cores, int kind) {
  const auto i = static_cast<std::size_t>(subchain);
  const Owned& alone = instance_.members[i].on_kind(kind).owned[static_cast<std::size_t>(cores - 1)];
  if (!std::isfinite(alone.period)) return kInfinity;
  return prices_.period[i] * alone.period + prices_.execution[i] * alone.execution;
}

double SharesSolver::price_of_shared(const std::vector<int>& members, int kind) {
  members_.assign(1, members);
  for (const int index : members) place(static_cast<std::size_t>(index), kind);
  least_frame_.resize(1);
  most_frame_.resize(1);
  usable_.resize(1);
  if (!limit_frames(full_)) return kInfinity;
  price_caps(members, usable_[0]);
  return solve_core(members, 0, full_);
}

}  // namespace ctn::planner
