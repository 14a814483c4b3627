#include <fmt/format.h>

#include <cmath>

#include "explain.h"
#include "plan/predict.h"
#include "plan_text.h"
#include "planner/planner.h"
#include "table.h"

namespace ctn::tool {
namespace {

using planner::Binding;
using planner::BoundCost;
using planner::Reason;

std::string percent(double part) { return fmt::format("{:.3g}%", 100.0 * part); }

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
      : explanation_(explanation), plan_(plan), app_(app), now_(explanation.again.expected->objective) {}

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

  // "+1.234ms (+5.6%)", or that nothing differs by more than noise.
  std::string change(double from, double to) const {
    const double difference = to - from;
    if (std::abs(difference) <= explanation_.noise * std::abs(from)) return "no change";
    return fmt::format("{:+.3f}ms ({:+.3g}%)", difference, 100.0 * difference / from);
  }

  std::string reasons() const {
    Table table({"subchain", "period", "because"});
    for (std::size_t i = 0; i < explanation_.reasons.size(); ++i) {
      table.add({name(SubchainId(i)), ms_text(explanation_.reasons[i].period), because(i)});
    }
    return table.text();
  }

  std::string because(std::size_t i) const {
    const Reason& reason = explanation_.reasons[i];
    switch (reason.binding) {
      case Binding::kExactRate:
        return fmt::format("its rate is given: min_rate and max_rate of {} are equal", name(*reason.node));
      case Binding::kRateCap:
        return fmt::format("the max_rate of {} allows no more", name(*reason.node));
      case Binding::kInput:
        return fmt::format("it runs for new output of {}, which comes no more often", name(*reason.node));
      case Binding::kLongestNode:
        return fmt::format("its longest node, {}: {} a run; more cores would not help", name(*reason.node),
                           ms_text(reason.cost));
      case Binding::kCost:
        return of_cost(i);
      case Binding::kBound:
        return fmt::format("{} {} it this fast; {}", in_words(reason.bounds),
                           reason.bounds.size() == 1 ? "keeps" : "keep", of_core(reason));
      case Binding::kLeader:
        return fmt::format("{} triggers it; {}", output_of(*reason.leader), of_core(reason));
      case Binding::kCore:
        return fmt::format("its core is full: {}, by the weights", of_core(reason));
      case Binding::kChosen:
        return fmt::format("{} of its core is used, and more often would not be better; {}", percent(reason.core_used),
                           of_core(reason));
    }
    return "";
  }

  std::string of_cost(std::size_t i) const {
    const std::size_t cores = plan_.subchains[i].cores.size();
    return fmt::format("its cost: {} a run on {} of its own", ms_text(explanation_.reasons[i].cost),
                       cores == 1 ? "a core" : fmt::format("{} cores", cores));
  }

  std::string output_of(const plan::After& leader) const {
    const std::string& who = leader.subchain() != nullptr ? name(*leader.subchain()) : name(*leader.node());
    return outputs_text(leader.every, who);
  }

  std::string of_core(const Reason& reason) const {
    if (reason.others.empty()) return fmt::format("alone on its core, for runs of {}", ms_text(reason.cost));
    return fmt::format("it gets {} of the core that it shares with {}, for runs of {}", percent(reason.core_part),
                       names(reason.others), ms_text(reason.cost));
  }

  std::string bounds() const {
    if (explanation_.bounds.empty()) return "\nwhat the bounds cost: there are none\n";
    Table table({"bound", "asked", "at worst", "objective without it", "so it costs"});
    for (const BoundCost& bound : explanation_.bounds) {
      const auto& without = bound.without.plan;
      table.add({bound.key, ms_text(bound.asked), ms_text(bound.planned),
                 without ? ms_text(Millis{without->expected->objective}) : "no plan: " + bound.without.refusal,
                 cost_text(bound)});
    }
    return "\nwhat the bounds cost\n" + table.text();
  }

  std::string cost_text(const BoundCost& bound) const {
    if (!bound.without.plan) return "";
    std::string text = "nothing";
    if (bound.cost > explanation_.noise * now_) {
      text = fmt::format("{} ({:.3g}%)", ms_text(Millis{bound.cost}), 100.0 * bound.cost / now_);
    }
    const double before = explanation_.again.relax_factor;
    const double factor = bound.without.plan->relax_factor;
    if (explanation_.bounds.size() == 1 || factor >= before * (1.0 - explanation_.noise)) return text;
    if (factor <= 1.0 + plan::kTolerance) return text + "; without it the others hold";
    return text + fmt::format("; without it the others give way by {:.4g}, not {:.4g}", factor, before);
  }

  std::string alternatives() const {
    Table table({"plan", "objective", "change", "relaxed by", "cores"});
    table.add(
        {"this one", ms_text(Millis{now_}), "", relaxed(explanation_.again), allocation(explanation_.again, app_)});
    for (std::size_t kind = 0; kind < explanation_.one_more.size(); ++kind) {
      add(table, "one" + of_kind(kind) + " core more", explanation_.one_more[kind], with(kind, 1));
    }
    for (std::size_t kind = 0; kind < explanation_.one_fewer.size(); ++kind) {
      if (const auto& fewer = explanation_.one_fewer[kind]) {
        add(table, "one" + of_kind(kind) + " core fewer", *fewer, with(kind, -1));
      }
    }
    return "\nother plans\n" + table.text();
  }

  void add(Table& table, const std::string& label, const planner::Variation& other, const graph::App& app) const {
    if (!other.plan) {
      table.add({label, "none", "", "", other.refusal});
      return;
    }
    const double objective = other.plan->expected->objective;
    table.add({label, ms_text(Millis{objective}), change(now_, objective), relaxed(*other.plan),
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

  // Only what changes. Cores that are divided differently for no change in any term are one of many ways.
  std::string doubled(const planner::DoubledWeight& other) const {
    if (!other.with.plan) return ": no plan, " + other.with.refusal + "\n";
    Table table({"", "  now", "then", "change"});
    bool any = false;
    for (std::size_t t = 0; t < other.terms.size(); ++t) {
      const double now = explanation_.terms[t].count();
      const std::string changed = change(now, other.terms[t].count());
      if (changed == "no change") continue;
      table.add({"  " + term(t), "  " + ms_text(Millis{now}), ms_text(Millis{other.terms[t]}), changed});
      any = true;
    }
    if (!any) return ": nothing changes\n";
    const std::string cores = other.allocation_changes ? "    cores: " + allocation(*other.with.plan, app_) + "\n" : "";
    return "\n" + table.text() + cores;
  }

  std::string caveat() const {
    std::string text;
    if (now_ < plan_.expected->objective) {
      text = fmt::format("Going on for longer with nothing changed gave {} in place of {}. ", ms_text(Millis{now_}),
                         ms_text(Millis{plan_.expected->objective}));
    }
    return fmt::format(
        "\nObjectives, periods and terms are as expected. Nothing of this is proven: each line is what a short search "
        "found.\n{}Differences of less than {} are taken for noise.\n",
        text, percent(explanation_.noise));
  }

  const planner::Explanation& explanation_;
  const plan::Plan& plan_;
  const graph::App& app_;
  double now_;  // what other plans are compared with
};

}  // namespace

std::string explain_text(const planner::Explanation& explanation, const plan::Plan& plan, const graph::App& app) {
  return Text(explanation, plan, app).all();
}

}  // namespace ctn::tool
