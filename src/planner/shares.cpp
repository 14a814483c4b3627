#include "planner/shares.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// No frame is longer than so many times one run of everything on its core: subchains that no term weighs would
// otherwise be put off without end.
constexpr double kLongestFrame = 100.0;
constexpr int kRounds = 80;         // of adjusting multipliers, at most
constexpr int kRoundsTogether = 4;  // after so many the gap must have shrunk

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

// Queue nodes with an exact rate take a known part of the core and have nothing left to decide.
bool set_apart(const Member& member) { return member.queue && member.exact_period > 0.0; }

double capped_at(const Member& member) { return std::max(member.min_period, member.exact_period); }

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
      slowest = std::max({slowest, member.min_period, member.exact_period});
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
        least = std::max(least, member.min_period / box.most[i]);
      }
    }
    if (!any_item) least = std::max(least, slowest);
    if (!(usable > 0.0)) return false;
    least_frame_[core] = least;
    usable_[core] = usable;
    most_frame_[core] = std::min(longest, std::max({kLongestFrame * total / usable, slowest, least}));
    if (least > most_frame_[core] * (1.0 + kSameFrame)) return false;
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
