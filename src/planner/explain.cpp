#include "planner/explain.h"

#include <algorithm>
#include <utility>

#include "model/batches.h"
#include "plan/limits.h"
#include "plan/predict.h"
#include "planner/planner.h"
#include "planner/scoring.h"

namespace ctn::planner {
namespace {

// Of what a core may be used for; from here on it is full.
constexpr double kFull = 0.95;
// A period is a cap's if it is longer by no more than this part: triggers are sometimes missed.
constexpr double kAtCap = 0.02;

// As expected, in the order of the objective.
std::vector<Millis> terms_of(const graph::App& app, const plan::Plan& plan) {
  std::vector<Millis> values;
  std::size_t chains = 0;
  std::size_t nodes = 0;
  for (const graph::Term& term : app.objective) {
    values.push_back(term.metric == graph::Metric::kPeriod ? plan::usual_period(app.graph, plan, plan.nodes[nodes++])
                                                           : plan.expected->chains[chains++].response);
  }
  return values;
}

double weighted_sum(const graph::App& app, const std::vector<Millis>& terms) {
  double sum = 0.0;
  for (std::size_t term = 0; term < terms.size(); ++term) sum += app.objective[term].weight * terms[term].count();
  return sum;
}

graph::App without(const graph::App& app, const plan::SoftBound& bound) {
  graph::App other = app;
  if (bound.term) {
    other.objective[*bound.term].max.reset();
  } else {
    other.graph = app.graph.without_min_rate(*bound.node);
  }
  return other;
}

// What each period comes from.
class Reasons {
 public:
  Reasons(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs, const plan::Plan& plan,
          const std::vector<BoundCost>& bounds)
      : app_(app), samples_(samples), costs_(costs), plan_(plan), bounds_(bounds), used_(plan.cores.size(), 0.0) {
    for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
      for (const int core : plan.subchains[i].cores) used_[static_cast<std::size_t>(core)] += part_of(i);
    }
  }

  Reason of(std::size_t i) const {
    const plan::SubchainPlan& entry = plan_.subchains[i];
    Reason reason;
    reason.period = period(i);
    reason.cost = run_time(i);
    for (std::size_t j = 0; j < plan_.subchains.size(); ++j) {
      if (j != i && plan_.subchains[j].cores.front() == entry.cores.front()) reason.others.emplace_back(j);
    }
    reason.core_part = part_of(i);
    reason.core_used = used_[static_cast<std::size_t>(entry.cores.front())];
    bind(i, reason);
    return reason;
  }

 private:
  Millis period(std::size_t i) const { return plan_.expected->subchains[i].period; }

  // On average, with the threads that it has.
  Millis node_time(std::size_t i, NodeId node) const {
    const std::size_t kind = app_.kind_of(plan_.subchains[i].cores.front());
    const Millis alone = Millis{samples_.moments(node, kind).mean} + batch_time(i, node, kind);
    return samples_.split(node, kind, plan_.subchains[i].threads).part * alone;
  }
  Millis batch_time(std::size_t i, NodeId node, std::size_t kind) const {
    if (!costs_.has_batches(node)) return Millis{0};
    return samples_.per_item(node, kind) * model::mean_items(model::batch_inputs(app_.graph, costs_, node), period(i),
                                                             [&](SubchainId id) { return period(id.index()); });
  }
  Millis run_time(std::size_t i) const {
    Millis sum{0};
    for (const NodeId node : app_.graph.subchain(SubchainId(i)).nodes) sum += node_time(i, node);
    return sum;
  }
  // Of each of its cores.
  double part_of(std::size_t i) const {
    if (period(i) <= Millis{0}) return 0.0;
    const plan::SubchainPlan& entry = plan_.subchains[i];
    const std::size_t kind = app_.kind_of(entry.cores.front());
    Millis cpu{0};
    for (const NodeId node : app_.graph.subchain(SubchainId(i)).nodes) {
      cpu += samples_.split(node, kind, entry.threads).threads * node_time(i, node);
    }
    return cpu / period(i) / (1.0 - plan_.slack) / static_cast<double>(entry.cores.size());
  }

  void bind(std::size_t i, Reason& reason) const {
    const plan::PeriodLimits limits = plan::period_limits(app_.graph, SubchainId(i));
    const plan::Member* const member = plan::member_of(plan_, SubchainId(i));
    if (limits.exact) {
      reason.binding = Binding::kExactRate;
      reason.node = limits.exact_of;
    } else if (limits.min > Millis{0} && reason.period <= limits.min * (1.0 + kAtCap)) {
      reason.binding = Binding::kRateCap;
      reason.node = limits.capped;
    } else if (const std::optional<NodeId> from = held_by_input(i, member)) {
      reason.binding = Binding::kInput;
      reason.node = from;
    } else if (plan_.subchains[i].cores.size() > 1) {
      of_pipeline(i, reason);
    } else if (reason.bounds = bounds_that_speed_up(i); !reason.bounds.empty()) {
      reason.binding = Binding::kBound;
    } else if (member != nullptr && member->after) {
      reason.binding = Binding::kLeader;
      reason.leader = member->after;
    } else if (reason.others.empty() && reason.core_used >= kFull) {
      reason.binding = Binding::kCost;
    } else if (reason.core_used >= kFull) {
      reason.binding = Binding::kCore;
    }
  }

  // The predecessor of its head that gives output most often, where it runs as often as that. Of one that follows
  // another, that says more.
  std::optional<NodeId> held_by_input(std::size_t i, const plan::Member* member) const {
    const NodeId head = app_.graph.subchain(SubchainId(i)).head();
    if (!app_.graph.awaits_input(head) || (member != nullptr && member->after)) return std::nullopt;
    std::optional<NodeId> from;
    for (const NodeId one : app_.graph.node(head).predecessors) {
      if (!from || outputs_apart(one) < outputs_apart(*from)) from = one;
    }
    if (period(i) > outputs_apart(*from) * (1.0 + kAtCap)) return std::nullopt;
    return from;
  }
  // As expected.
  Millis outputs_apart(NodeId id) const {
    const graph::Node& node = app_.graph.node(id);
    if (node.external) return to_millis(*node.period);
    if (!node.subchain) return to_millis(node.outputs_apart()) * costs_.runs_per_output(id);
    const double runs_per_output = costs_.runs_per_output(app_.graph.subchain(*node.subchain), id);
    return std::max(period(node.subchain->index()) * runs_per_output, to_millis(app_.graph.output_period_up_to(id)));
  }

  void of_pipeline(std::size_t i, Reason& reason) const {
    const plan::SubchainPlan& entry = plan_.subchains[i];
    const std::vector<NodeId>& nodes = app_.graph.subchain(SubchainId(i)).nodes;
    const NodeId longest = *std::max_element(nodes.begin(), nodes.end(),
                                             [&](NodeId a, NodeId b) { return node_time(i, a) < node_time(i, b); });
    const int pipelines = std::max(1, static_cast<int>(entry.cores.size()) / entry.threads);
    reason.binding = Binding::kCost;
    if (node_time(i, longest) < reason.cost / pipelines) return;
    reason.binding = Binding::kLongestNode;
    reason.node = longest;
    reason.cost = node_time(i, longest);
  }

  std::vector<std::string> bounds_that_speed_up(std::size_t i) const {
    const std::vector<plan::SoftBound> asked = plan::soft_bounds(app_);
    std::vector<std::string> keys;
    for (std::size_t b = 0; b < asked.size(); ++b) {
      const std::optional<plan::Plan>& other = bounds_[b].without.plan;
      if (!bounds_[b].binds || !other || !is_about(asked[b], i)) continue;
      constexpr double kSlower = 1.05;
      if (other->expected->subchains[i].period > kSlower * period(i)) keys.push_back(asked[b].key);
    }
    return keys;
  }

  bool is_about(const plan::SoftBound& bound, std::size_t i) const {
    const auto in_it = [&](NodeId node) { return app_.graph.node(node).subchain == SubchainId(i); };
    if (bound.node) return in_it(*bound.node);
    const std::vector<NodeId>& path = app_.objective[*bound.term].path;
    return std::any_of(path.begin(), path.end(), in_it);
  }

  const graph::App& app_;
  const trial::Samples& samples_;
  const model::CostTable& costs_;
  const plan::Plan& plan_;
  const std::vector<BoundCost>& bounds_;
  std::vector<double> used_;  // by core
};

class Explaining {
 public:
  Explaining(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
             const ExpectedRequest& request, const plan::Plan& plan)
      : app_(app), samples_(samples), costs_(costs), request_(request), plan_(plan), bounds_(plan::soft_bounds(app)) {
    request_.effort *= kEffortAgain;
    request_.known = &plan;
    all_ = 1 + bounds_.size() + 2 * app.kinds() + app.objective.size();
    request_.on_progress = [this, &request](double part) {
      if (request.on_progress) request.on_progress((static_cast<double>(done_) + part) / static_cast<double>(all_));
    };
  }

  Explanation run() {
    const Variation again = planned(app_, request_);
    Explanation explanation;
    again_ = again.plan && score(*again.plan) < score(plan_) ? *again.plan : plan_;
    for (std::size_t term = 0; term < app_.objective.size(); ++term) {
      explanation.doubled.push_back(doubled(term));
      if (!explanation.doubled.back().with.plan) continue;
      const plan::Plan found = weighed(app_, *explanation.doubled.back().with.plan);
      if (score(found) < score(again_)) again_ = found;
    }
    request_.known = &again_;
    explanation.again = again_;
    const double now = explanation.again.expected->objective;
    explanation.noise = std::max(kMinNoise, score(plan_) / score(explanation.again) - 1.0);
    explanation.terms = terms_of(app_, explanation.again);
    for (const plan::SoftBound& bound : bounds_) explanation.bounds.push_back(cost_of(bound, now, explanation.noise));
    const Reasons reasons(app_, samples_, costs_, plan_, explanation.bounds);
    for (std::size_t i = 0; i < plan_.subchains.size(); ++i) explanation.reasons.push_back(reasons.of(i));
    const std::vector<int> counts = app_.cores_by_kind(request_.cores);
    for (std::size_t kind = 0; kind < app_.kinds(); ++kind) {
      explanation.one_more.push_back(with_cores(kind, 1));
      const bool another = request_.cores > 1 && counts[kind] > 0;
      explanation.one_fewer.push_back(another ? std::optional(with_cores(kind, -1)) : std::nullopt);
    }
    for (std::size_t term = 0; term < app_.objective.size(); ++term) {
      compare(explanation.doubled[term], term);
    }
    return explanation;
  }

 private:
  static double score(const plan::Plan& plan) { return relaxed_score(plan.expected->objective, plan.relax_factor); }

  Variation planned(const graph::App& app, const ExpectedRequest& request) {
    Result<plan::Plan> plan = make_expected_plan(app, samples_, costs_, request);
    ++done_;
    if (!plan) return {std::nullopt, plan.error().message()};
    return {*std::move(plan), ""};
  }

  // What is known of other cores is a beginning only where they keep their numbers.
  Variation with_cores(std::size_t kind, int more) {
    ExpectedRequest request = request_;
    request.cores += more;
    if (more < 0 || !app_.core_kinds.empty()) request.known = nullptr;
    return planned(with_more_cores(app_, request_.cores, kind, more), request);
  }

  Millis promised(const plan::SoftBound& bound) const {
    const plan::Prediction promised = plan::predict(app_, costs_, plan_.subchains, plan_.cores);
    if (bound.term) {
      std::size_t chain = 0;
      for (std::size_t term = 0; term < *bound.term; ++term) {
        if (app_.objective[term].metric == graph::Metric::kResponseTime) ++chain;
      }
      return promised.chains[chain].response;
    }
    return plan_.subchains[app_.graph.node(*bound.node).subchain->index()].period;
  }

  BoundCost cost_of(const plan::SoftBound& bound, double now, double noise) {
    BoundCost found;
    found.key = bound.key;
    found.asked = bound.asked;
    found.planned = promised(bound);
    found.without = planned(without(app_, bound), request_);
    if (found.without.plan) found.cost = now - found.without.plan->expected->objective;
    found.binds = found.cost > noise * now || found.planned > bound.asked * (1.0 + plan::kTolerance);
    return found;
  }

  graph::App with_doubled(std::size_t term) const {
    graph::App other = app_;
    other.objective[term].weight *= 2.0;
    return other;
  }

  DoubledWeight doubled(std::size_t term) {
    DoubledWeight found;
    found.with = planned(with_doubled(term), request_);
    return found;
  }

  // A plan that was made for other weights, as the app has them.
  plan::Plan weighed(const graph::App& app, plan::Plan plan) const {
    plan::fill_predictions(plan, app, costs_);
    plan.expected->objective = weighted_sum(app, terms_of(app, plan));
    return plan;
  }

  // Each search finds what it finds; what another one found that is better counts, or a weight would seem to do what
  // luck did.
  void compare(DoubledWeight& found, std::size_t term) const {
    if (!found.with.plan) return;
    const plan::Plan as_now = weighed(with_doubled(term), again_);
    if (score(as_now) < score(*found.with.plan)) found.with.plan = as_now;
    found.terms = terms_of(app_, *found.with.plan);
    found.objective = weighted_sum(app_, found.terms);
    found.allocation_changes = allocation_groups(*found.with.plan, app_) != allocation_groups(again_, app_);
  }

  const graph::App& app_;
  const trial::Samples& samples_;
  const model::CostTable& costs_;
  ExpectedRequest request_;
  const plan::Plan& plan_;
  const std::vector<plan::SoftBound> bounds_;
  plan::Plan again_;     // the best that was found
  std::size_t all_ = 0;  // plans to be made
  std::size_t done_ = 0;
};

}  // namespace

std::vector<CoreGroup> allocation_groups(const plan::Plan& plan, const graph::App& app) {
  std::vector<CoreGroup> groups;
  std::vector<int> first;  // core of each group
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const std::vector<int>& cores = plan.subchains[i].cores;
    const auto known = std::find(first.begin(), first.end(), cores.front());
    if (known != first.end()) {
      groups[static_cast<std::size_t>(known - first.begin())].subchains.emplace_back(i);
      continue;
    }
    first.push_back(cores.front());
    groups.push_back({{SubchainId(i)}, static_cast<int>(cores.size()), static_cast<int>(app.kind_of(cores.front()))});
  }
  return groups;
}

Explanation explain(const graph::App& app, const trial::Samples& samples, const model::CostTable& costs,
                    const ExpectedRequest& request, const plan::Plan& plan) {
  return Explaining(app, samples, costs, request, plan).run();
}

}  // namespace ctn::planner
