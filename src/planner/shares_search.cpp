// The second half of SharesSolver: from a point of the relaxation to whole numbers, and what is divided where these are
// not the best yet.
#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/frame_fit.h"
#include "planner/shares.h"

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Bounds and exact rates hold if they are missed by no more than this part.
constexpr double kMet = 1e-10;
constexpr std::size_t kFitEffort = 100;

bool whole(const Member& member) { return !member.queue; }

}  // namespace

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
    least = std::max(least, member.min_period / every[i]);
    if (member.exact_period > 0.0) {
      const double given = member.exact_period / every[i];
      if (exact > 0.0 && std::abs(given - exact) > kMet * exact) return false;
      exact = std::max(exact, given);
    }
  }
  frame = free ? std::max({point_.frames[k], busy / usable_[k] * (1.0 + kSameFrame), least})
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
          member.exact_period > 0.0 ? member.exact_period : std::max(every[i] * point_.frames[k], member.min_period);
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
    period = scale > 1.0 ? period * scale : std::max(period * scale, member.min_period);
    if (period > full_.most[i] * frame * (1.0 + kSameFrame)) return false;
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
      double period = std::max(cost_[i] / usable_[core], member.min_period);
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
      } else if (period < member.min_period * (1.0 - kMet)) {
        miss = (member.min_period - period) / member.min_period;
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

// It solves equations in its variables: free periods, frames, and the groups' maxima.
std::size_t SharesSolver::fit_effort() const {
  constexpr std::size_t kOfCube = 100;  // multiplications, in thousands
  if (instance_.members.size() <= kCheap) return kFitEffort;
  std::size_t variables = members_.size() + target_.limits.size();
  for (const std::vector<int>& members : members_) {
    for (const int index : members) variables += instance_.members[static_cast<std::size_t>(index)].queue ? 1 : 0;
  }
  for (const Group& group : target_.groups) variables += group.forms.size() > 1 && group.weight > 0.0 ? 1 : 0;
  return kFitEffort + variables * variables * variables / kOfCube;
}

// False: free shares are left as they were found, though better ones may exist.
bool SharesSolver::finish_leaf(const Allocation& allocation, const Box& box, bool may_fit) {
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
  if (!free || !contested_) return true;
  if (!may_fit) return false;
  FrameFit fit{instance_, target_, members_, cost_, full_.most, usable_, least_frame_, most_frame_};
  std::vector<Timing> timings = point_.timings;
  std::vector<double> frames = point_.frames;
  if (fit.solve(every, timings, frames)) keep(timings, frames);
  return true;
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
    const std::size_t fit = fit_effort();
    const bool may_fit = fit == kFitEffort || fit < effort.left;
    if (!finish_leaf(allocation, node.box, may_fit)) unfitted_ = std::min(unfitted_, std::max(node.bound, bound));
    effort.spend(may_fit ? fit : kFitEffort);
    return;
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

Shares SharesSolver::solve(const Allocation& allocation, double cutoff, Effort& effort) {
  prepare(allocation);
  best_ = {};
  cutoff_ = cutoff;
  unfitted_ = kInfinity;
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
  best_.bound = std::min({best_.value, cutoff, unfitted_});
  for (const Node& node : open) best_.bound = std::min(best_.bound, node.bound);
  return std::move(best_);
}

}  // namespace ctn::planner
