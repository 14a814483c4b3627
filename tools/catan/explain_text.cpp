#include <fmt/format.h>

#include <cmath>

#include "explain.h"
#include "plan/predict.h"
#include "table.h"

namespace ctn::tool {
namespace {

using planner::Binding;
using planner::BoundCost;
using planner::Reason;

std::string ms(double duration) { return fmt::format("{:.3f}ms", duration); }
std::string ms(Millis duration) { return ms(duration.count()); }
std::string percent(double part) { return fmt::format("{:.3g}%", 100.0 * part); }

// "+1.234ms (+5.6%)", or that nothing differs.
std::string change(double from, double to) {
  const double difference = to - from;
  if (std::abs(difference) <= plan::kTolerance * std::abs(from)) return "no change";
  if (from <= 0.0) return fmt::format("{:+.3f}ms", difference);
  return fmt::format("{:+.3f}ms ({:+.3g}%)", difference, 100.0 * difference / from);
}

std::string in_words(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += i + 1 == parts.size() ? " and " : ", ";
    text += parts[i];
  }
  return text;
}

class Text {
 public:
  Text(const planner::Explanation& explanation, const plan::Plan& plan, const graph::App& app)
      : explanation_(explanation), plan_(plan), app_(app) {}

  std::string all() const {
    return fmt::format("\nwhy these periods\n{}{}{}{}{}", reasons(), bounds(), alternatives(), weights(), caveat());
  }

 private:
  const std::string& name(SubchainId id) const { return app_.graph.subchain(id).name; }
  const std::string& name(NodeId id) const { return app_.graph.node(id).name; }

  std::string names(const std::vector<SubchainId>& ids) const {
    std::vector<std::string> all;
    for (const SubchainId id : ids) all.push_back(name(id));
    return in_words(all);
  }

  // "response time of scan -> LM", "period of GL".
  std::string term(std::size_t index) const {
    const graph::Term& term = app_.objective[index];
    return term.metric == graph::Metric::kPeriod ? "period of " + name(term.path.front())
                                                 : "response time of " + app_.graph.path_name(term.path);
  }

  std::string reasons() const {
    Table table({"subchain", "period", "because"});
    for (std::size_t i = 0; i < explanation_.reasons.size(); ++i) {
      table.add({name(SubchainId(i)), ms(plan_.subchains[i].period), because(i)});
    }
    return table.text();
  }

  std::string because(std::size_t i) const {
    const Reason& reason = explanation_.reasons[i];
    switch (reason.binding) {
      case Binding::kNothing:
        return "it costs nothing";
      case Binding::kExactRate:
        return fmt::format("its rate is given: min_rate and max_rate of {} are equal", name(*reason.node));
      case Binding::kRateCap:
        return fmt::format("the max_rate of {} allows no more", name(*reason.node));
      case Binding::kLongestNode:
        return fmt::format("its longest node, {}: {} a run; more cores would not help", name(*reason.node),
                           ms(reason.cost));
      case Binding::kCost:
        return of_cost(i);
      default:
        return of_sharer(i);
    }
  }

  std::string of_cost(std::size_t i) const {
    const std::size_t cores = plan_.subchains[i].cores.size();
    return fmt::format("its cost: {} a run on {} of its own", ms(explanation_.reasons[i].cost),
                       cores == 1 ? "a core" : fmt::format("{} cores", cores));
  }

  std::string of_sharer(std::size_t i) const {
    const Reason& reason = explanation_.reasons[i];
    const std::string core = fmt::format("its core, shared with {}: it gets {} of it for runs of {}",
                                         names(reason.others), percent(reason.core_part), ms(reason.cost));
    switch (reason.binding) {
      case Binding::kOtherRate:
        return fmt::format("the frame of its core waits for the rate of {}; {} of the core is left idle",
                           name(*reason.through), percent(idle(i)));
      case Binding::kMinSlice:
        return plan_.subchains[i].every == 1
                   ? fmt::format("min_slice: its run of {} may not be split over frames, which would be better",
                                 ms(reason.cost))
                   : fmt::format("min_slice: its slice of {} may be no shorter, which would be better",
                                 ms(plan_.subchains[i].slice));
      case Binding::kBound:
        return fmt::format("{} {} it this fast, at the expense of {}", in_words(reason.bounds),
                           reason.bounds.size() == 1 ? "keeps" : "keep", names(reason.others));
      case Binding::kOtherBound:
        return fmt::format("{}; slowed by {}{}", core, in_words(reason.bounds),
                           reason.bounds.size() == 1 ? ", which keeps " + name(*reason.through) + " fast" : "");
      default:
        return core;
    }
  }

  double idle(std::size_t i) const {
    const plan::CorePlan& core = plan_.cores[static_cast<std::size_t>(plan_.subchains[i].cores.front())];
    return core.idle / core.frame;
  }

  std::string bounds() const {
    if (explanation_.bounds.empty()) return "\nwhat the bounds cost: there are none\n";
    Table table({"bound", "asked", "planned", "objective without it", "so it costs"});
    for (const BoundCost& bound : explanation_.bounds) {
      const auto& without = bound.without.plan;
      table.add({bound.key, ms(bound.asked), ms(bound.planned),
                 without ? ms(without->objective) : "no plan: " + bound.without.refusal, cost_text(bound)});
    }
    return "\nwhat the bounds cost\n" + table.text();
  }

  std::string cost_text(const BoundCost& bound) const {
    if (!bound.without.plan) return "";
    std::string text = "nothing";
    if (bound.cost > plan::kTolerance * plan_.objective) {
      text = fmt::format("{} ({:.3g}%)", ms(bound.cost), 100.0 * bound.cost / plan_.objective);
    }
    const double factor = bound.without.plan->relax_factor;
    if (explanation_.bounds.size() == 1 || factor >= plan_.relax_factor * (1.0 - plan::kTolerance)) return text;
    if (factor <= 1.0 + plan::kTolerance) return text + "; without it the others hold";
    return text + fmt::format("; without it the others give way by {:.4g}, not {:.4g}", factor, plan_.relax_factor);
  }

  std::string alternatives() const {
    Table table({"plan", "objective", "change", "relaxed by", "cores"});
    table.add({"this one", ms(plan_.objective), "", relaxed(plan_), allocation(plan_, app_)});
    for (std::size_t kind = 0; kind < explanation_.one_more.size(); ++kind) {
      add(table, "one" + of_kind(kind) + " core more", explanation_.one_more[kind], with(kind, 1));
    }
    for (std::size_t kind = 0; kind < explanation_.one_fewer.size(); ++kind) {
      if (const auto& fewer = explanation_.one_fewer[kind]) {
        add(table, "one" + of_kind(kind) + " core fewer", *fewer, with(kind, -1));
      }
    }
    const planner::RunnerUp& runner_up = explanation_.runner_up;
    if (runner_up.plan) {
      add(table, label(runner_up), {runner_up.plan, ""}, app_);
    } else {
      table.add({"other allocation", "none", "", "", ""});
    }
    return "\nother plans\n" + table.text();
  }

  // An allocation made in two stages need not be the best.
  std::string label(const planner::RunnerUp& runner_up) const {
    if (!runner_up.proven) return "best other allocation found";
    const plan::Plan& other = *runner_up.plan;
    const bool better = other.relax_factor < plan_.relax_factor * (1.0 - plan::kTolerance) ||
                        (other.relax_factor <= plan_.relax_factor * (1.0 + plan::kTolerance) &&
                         other.objective < plan_.objective * (1.0 - plan::kTolerance));
    return better ? "best allocation" : "next best allocation";
  }

  void add(Table& table, const std::string& label, const planner::Variation& other, const graph::App& app) const {
    if (!other.plan) {
      table.add({label, "none", "", "", other.refusal});
      return;
    }
    table.add({label, ms(other.plan->objective), change(plan_.objective, other.plan->objective), relaxed(*other.plan),
               allocation(*other.plan, app)});
  }

  // " big" where cores differ, else nothing.
  std::string of_kind(std::size_t kind) const {
    return app_.core_kinds.empty() ? "" : " " + app_.core_kinds[kind].name;
  }
  graph::App with(std::size_t kind, int more) const {
    return planner::with_more_cores(app_, static_cast<int>(plan_.cores.size()), kind, more);
  }

  // Empty for all plans: the column is left out.
  static std::string relaxed(const plan::Plan& plan) {
    return plan.relax_factor > 1.0 + plan::kTolerance ? fmt::format("{:.4g}", plan.relax_factor) : "";
  }

  std::string allocation(const plan::Plan& plan, const graph::App& app) const {
    std::vector<std::string> parts;
    int used = 0;
    for (const planner::CoreGroup& group : planner::allocation_groups(plan, app)) {
      used += group.cores;
      const std::string& first = name(group.subchains.front());
      const std::string kind = of_kind(static_cast<std::size_t>(group.kind));
      if (group.subchains.size() > 1) {
        parts.push_back(fmt::format("{} share one{}", names(group.subchains), kind));
      } else {
        const std::string cores = group.cores == 1 ? "one" : fmt::format("{}", group.cores);
        parts.push_back(fmt::format("{} has {}{}", first, cores, kind));
      }
    }
    const auto unused = static_cast<int>(plan.cores.size()) - used;
    if (unused > 0) parts.push_back(fmt::format("{} not needed", unused));
    return fmt::format("{}", fmt::join(parts, "; "));
  }

  std::string weights() const {
    std::string text = "\nif a weight doubled\n";
    for (std::size_t i = 0; i < explanation_.doubled.size(); ++i) {
      text += fmt::format("  {} (weight {:.6g} -> {:.6g}){}", term(i), app_.objective[i].weight,
                          2.0 * app_.objective[i].weight, doubled(explanation_.doubled[i]));
    }
    return text;
  }

  std::string doubled(const planner::DoubledWeight& other) const {
    if (!other.with.plan) return ": no plan, " + other.with.refusal + "\n";
    const std::string cores = other.allocation_changes ? "    cores: " + allocation(*other.with.plan, app_) + "\n" : "";
    if (same(other)) return ": nothing changes\n" + cores;
    Table table({"", "  now", "then", "change"});
    for (std::size_t t = 0; t < other.terms.size(); ++t) {
      const double now = explanation_.terms[t].count();
      const std::string changed = change(now, other.terms[t].count());
      if (changed != "no change") table.add({"  " + term(t), "  " + ms(now), ms(other.terms[t]), changed});
    }
    return "\n" + table.text() + cores;
  }

  bool same(const planner::DoubledWeight& other) const {
    for (std::size_t t = 0; t < other.terms.size(); ++t) {
      if (change(explanation_.terms[t].count(), other.terms[t].count()) != "no change") return false;
    }
    return true;
  }

  std::string caveat() const {
    if (plan_.quality == plan::Quality::kOptimal) return "";
    return fmt::format("\nThis plan may be up to {} from the optimum: smaller differences than that say nothing.\n",
                       percent(plan_.gap));
  }

  const planner::Explanation& explanation_;
  const plan::Plan& plan_;
  const graph::App& app_;
};

}  // namespace

std::string explain_text(const planner::Explanation& explanation, const plan::Plan& plan, const graph::App& app) {
  return Text(explanation, plan, app).all();
}

}  // namespace ctn::tool
