#include "plan_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "plan/above_promise.h"
#include "table.h"

namespace ctn::tool {
namespace {

std::string every_text(const std::optional<int>& every) { return every ? fmt::format("{}", *every) : "-"; }

// What is proven of the plan, or how it was found.
std::string quality(const plan::Plan& plan) {
  if (plan.quality == plan::Quality::kOptimal) return "optimal, ";
  return plan.gap < 1.0 ? fmt::format("at most {:.3g}% from the optimum, ", plan.gap * 100.0) : "";
}

std::string title(const plan::Plan& plan, const graph::App& app) {
  const std::string objective = plan.expected ? fmt::format("objective {:.6g}ms expected, {:.6g}ms at worst",
                                                            plan.expected->objective, plan.objective)
                                              : fmt::format("objective {:.6g}ms", plan.objective);
  return fmt::format("{} on {} core{}: {}{}\n{}, slack {:.3g}%, solved in {}\n", app.name, plan.cores.size(),
                     plan.cores.size() == 1 ? "" : "s", quality(plan), objective, plan.planner, plan.slack * 100.0,
                     ms_text(plan.solve_time));
}

// Where something is expected, rates are, and periods are both: as expected and at worst.
std::string subchains_text(const plan::Plan& plan, const graph::App& app) {
  Table table(
      {"subchain", "nodes", "cores", "rate", "period", "at worst", "execution", "slice", "share", "every", "threads"});
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& entry = plan.subchains[i];
    const graph::Subchain& subchain = app.graph.subchain(SubchainId(i));
    const Millis period = plan::usual_timing(plan, SubchainId(i)).period;
    table.add({subchain.name, app.graph.path_name(subchain.nodes), fmt::format("{}", fmt::join(entry.cores, ",")),
               period.count() > 0 ? fmt::format("{:.2f}Hz", 1000.0 / period.count()) : "-", ms_text(period),
               plan.expected ? ms_text(entry.period) : "", ms_text(entry.execution), ms_text(entry.slice),
               fmt::format("{:.3g}", entry.share), every_text(entry.every), fmt::format("{}", entry.threads)});
  }
  return table.text();
}

// Of a core without a frame: one subchain owns it, or nothing does.
std::string owner_text(const plan::Plan& plan, const graph::App& app, int core) {
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const auto& cores = plan.subchains[i].cores;
    if (std::find(cores.begin(), cores.end(), core) != cores.end()) {
      return "all " + app.graph.subchain(SubchainId(i)).name;
    }
  }
  return "unused";
}

// Empty where no core has fixed priorities.
std::string priorities_text(const plan::Plan& plan, const graph::App& app) {
  Table table({"core", "priority", "subchain", "triggered", "budget"});
  bool any = false;
  for (std::size_t i = 0; i < plan.cores.size(); ++i) {
    for (const plan::Member& member : plan.cores[i].members) {
      table.add({fmt::format("{}", i), fmt::format("{}", member.priority), app.graph.subchain(member.subchain).name,
                 trigger_text(member, app), ms_text(member.budget)});
      any = true;
    }
  }
  return any ? "\nfixed priorities\n" + table.text() : "";
}

std::string cores_text(const plan::Plan& plan, const graph::App& app) {
  Table table({"core", "frame", "at least", "frames", "slots (offset + slice)", "idle"});
  for (std::size_t i = 0; i < plan.cores.size(); ++i) {
    const plan::CorePlan& core = plan.cores[i];
    std::vector<std::string> slots;
    for (const plan::Slot& slot : core.slots) {
      slots.push_back(fmt::format("{} {:.3f} + {}", app.graph.subchain(slot.subchain).name, slot.offset.count(),
                                  ms_text(slot.slice)));
    }
    const auto number = static_cast<int>(i);
    const std::string label = app.core_kinds.empty()
                                  ? fmt::format("{}", i)
                                  : fmt::format("{} {}", i, app.core_kinds[app.kind_of(number)].name);
    if (core.form == plan::Form::kPriorities) {
      table.add({label, "", "", "", "fixed priorities", ""});
      continue;
    }
    if (slots.empty()) {
      table.add({label, "", "", "", owner_text(plan, app, number), ""});
      continue;
    }
    table.add({label, ms_text(core.frame), core.frame_min.count() > 0 ? ms_text(core.frame_min) : "",
               core.frames == graph::FrameMode::kElastic ? "elastic" : "fixed",
               fmt::format("{}", fmt::join(slots, " | ")), ms_text(core.idle)});
  }
  return table.text();
}

// Empty where no run waits.
std::string waits_text(const plan::Plan& plan, const graph::App& app) {
  Table table({"subchain", "waits", "of its execution"});
  bool any = false;
  for (std::size_t i = 0; i < plan.subchains.size(); ++i) {
    const plan::SubchainPlan& entry = plan.subchains[i];
    if (entry.wait <= Millis{0}) continue;
    table.add({app.graph.subchain(SubchainId(i)).name, ms_text(entry.wait), ms_text(entry.execution)});
    any = true;
  }
  return any ? "\nruns that wait, and leave their core to others meanwhile\n" + table.text() : "";
}

// As promised, beside what is expected where that is known.
std::string terms_text(const plan::Plan& plan, const graph::App& app) {
  const bool both = plan.expected.has_value();
  Table table({"weight", "of", "expected", both ? "at worst" : "value", "latency", "period", "path"});
  for (std::size_t i = 0; i < plan.chains.size(); ++i) {
    const plan::ChainPlan& chain = plan.chains[i];
    table.add({fmt::format("{:.6g}", chain.weight), "response time",
               both ? ms_text(plan.expected->chains[i].response) : "", ms_text(chain.response), ms_text(chain.latency),
               ms_text(chain.period), app.graph.path_name(chain.path)});
  }
  for (const plan::NodePlan& node : plan.nodes) {
    table.add({fmt::format("{:.6g}", node.weight), "period",
               both ? ms_text(plan::usual_period(app.graph, plan, node)) : "", ms_text(node.period), "", "",
               app.graph.node(node.node).name});
  }
  return table.text();
}

// Empty where no chain is.
std::string above_promise_text(const plan::Plan& plan, const graph::App& app) {
  std::string text;
  for (const std::size_t chain : plan::chains_above_promise(plan)) {
    text += fmt::format("\nwarning: {} is expected to take {}, longer than it is promised ({}): it may be that {}\n",
                        app.graph.path_name(plan.chains[chain].path), ms_text(plan.expected->chains[chain].response),
                        ms_text(plan.chains[chain].response), plan::why_above_promise(plan, app));
  }
  return text;
}

std::string relaxed_text(const plan::Plan& plan) {
  if (plan.relaxed.empty()) return "";
  Table table({"bound", "asked", "planned"});
  for (const plan::RelaxedBound& bound : plan.relaxed)
    table.add({bound.key, ms_text(bound.asked), ms_text(bound.planned)});
  return fmt::format("\nnot all bounds can hold: relaxed by a factor of {:.4g}\n{}", plan.relax_factor, table.text());
}

}  // namespace

std::string outputs_text(int every, const std::string& leader) {
  return every == 1 ? "each output of " + leader : fmt::format("every {} output of {}", ordinal(every), leader);
}

std::string trigger_text(const plan::Member& member, const graph::App& app) {
  if (member.after) {
    const SubchainId* const subchain = member.after->subchain();
    const std::string& leader =
        subchain != nullptr ? app.graph.subchain(*subchain).name : app.graph.node(*member.after->node()).name;
    return outputs_text(member.after->every, leader);
  }
  if (member.pause) return fmt::format("{} after its end", ms_text(*member.pause));
  const std::string clock = member.clock ? " after a tick of " + app.graph.node(*member.clock).name : "";
  return fmt::format("every {} from {}{}", ms_text(member.period), ms_text(member.phase), clock);
}

std::string plan_text(const plan::Plan& plan, const graph::App& app) {
  return fmt::format("{}\nsubchains\n{}{}\ncores\n{}{}\nobjective\n{}{}{}", title(plan, app), subchains_text(plan, app),
                     waits_text(plan, app), cores_text(plan, app), priorities_text(plan, app), terms_text(plan, app),
                     relaxed_text(plan), above_promise_text(plan, app));
}

}  // namespace ctn::tool
