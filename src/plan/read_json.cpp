// The schema of a plan (docs/plan-schema.md), read strictly.
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "plan/json.h"
#include "plan/strict_json.h"

namespace ctn::plan {
namespace {

class Reader : private StrictJson {
 public:
  Reader(const graph::App& app, std::string_view file)
      : StrictJson(file, "write it as docs/plan-schema.md says, or make the plan again"), app_(app) {}

  Result<Plan> read(std::string_view text) {
    Plan plan;
    if (const std::optional<Json> document = parse(text)) read_plan(*document, plan);
    if (has_problems()) return Error(ErrorKind::kCaller, take_problems());
    return plan;
  }

 private:
  // Calls `each(element, path, subchain)` for the members of the object under `subchains`, which has to name them all.
  template <class Each>
  void each_subchain(const Json& parent, const std::string& path, Each each) {
    const Json* value = member(parent, "subchains");
    if (!value) return;
    const std::string here = child(path, "subchains");
    if (!value->is_object()) return problem(here, fmt::format("this is {}, not an object", value->type_name()));
    for (const auto& [name, element] : value->items()) {
      if (const auto id = app_.graph.find_subchain(name)) {
        each(element, child(here, name), *id);
      } else {
        problem(child(here, name), fmt::format("app '{}' has no such subchain", app_.name));
      }
    }
    for (const graph::Subchain& subchain : app_.graph.subchains()) {
      if (!value->contains(subchain.name)) problem(child(here, subchain.name), "the subchain is missing");
    }
  }

  void read_every(const Json& parent, const std::string& path, std::optional<int>& out) {
    const Json* value = member(parent, "every");
    if (value && !value->is_null()) out = whole(*value, child(path, "every"));
  }

  NodeId node_named(const Json& name, const std::string& path) {
    const auto found = name.is_string() ? app_.graph.find_node(name.get<std::string>()) : std::nullopt;
    if (!found) problem(path, fmt::format("{} is no node of app '{}'", shown(name), app_.name));
    return found.value_or(NodeId{});
  }

  void read_plan(const Json& value, Plan& plan);
  void read_relaxed(const Json& parent, Plan& plan);
  void read_subchains(const Json& parent, Plan& plan);
  void read_subchain(const Json& value, const std::string& path, SubchainPlan& subchain);
  void read_core(const Json& value, const std::string& path, Plan& plan);
  void read_slot(const Json& value, const std::string& path, CorePlan& core);
  void read_member(const Json& value, const std::string& path, CorePlan& core);
  void read_after(const Json& value, const std::string& path, Member& member);
  SubchainId subchain_named(const Json& parent, const std::string& path);
  void read_chain(const Json& value, const std::string& path, Plan& plan);
  void read_node(const Json& value, const std::string& path, Plan& plan);
  void read_assumed(const Json& value, const std::string& path, Plan& plan);
  void read_output(const Json& value, const std::string& path, Plan& plan);
  void read_batch(const Json& value, const std::string& path, Plan& plan);
  void read_expected(const Json& value, Plan& plan);

  const graph::App& app_;
};

void Reader::read_plan(const Json& value, Plan& plan) {
  if (!object(value, "",
              {"app", "planner", "status", "gap", "solve_ms", "objective", "slack", "relaxed", "subchains", "cores",
               "chains", "nodes"},
              {"version", "assumed", "outputs", "batches", "promises_for", "expected"})) {
    return;
  }
  int version = 1;
  read_int(value, "", "version", version);
  if (version < 1 || version > kJsonVersion) {
    problem("version", fmt::format("this catan reads versions 1 to {}, not {}", kJsonVersion, version));
  }
  if (const std::string app = read_text(value, "", "app"); value.contains("app") && app != app_.name) {
    problem("app", fmt::format("the plan is for app '{}', not for '{}'", app, app_.name), "give the plan of this app");
  }
  plan.planner = read_text(value, "", "planner");
  const std::string status = read_text(value, "", "status");
  if (value.contains("status") && status != "optimal" && status != "feasible") {
    problem("status", fmt::format("there is no status '{}'", status), "write optimal or feasible");
  }
  plan.quality = status == "feasible" ? Quality::kFeasible : Quality::kOptimal;
  read_number(value, "", "gap", plan.gap);
  read_millis(value, "", "solve_ms", plan.solve_time);
  read_number(value, "", "objective", plan.objective);
  read_number(value, "", "slack", plan.slack);
  read_relaxed(value, plan);
  read_subchains(value, plan);
  read_array(value, "", "cores", [&](const Json& e, const std::string& path) { read_core(e, path, plan); });
  read_array(value, "", "chains", [&](const Json& e, const std::string& path) { read_chain(e, path, plan); });
  read_array(value, "", "nodes", [&](const Json& e, const std::string& path) { read_node(e, path, plan); });
  read_array(value, "", "assumed", [&](const Json& e, const std::string& path) { read_assumed(e, path, plan); });
  read_array(value, "", "outputs", [&](const Json& e, const std::string& path) { read_output(e, path, plan); });
  read_array(value, "", "batches", [&](const Json& e, const std::string& path) { read_batch(e, path, plan); });
  if (value.contains("promises_for")) {
    const std::string costs = read_text(value, "", "promises_for");
    plan.for_typical = costs == promises_for(true);
    if (!plan.for_typical && costs != promises_for(false)) {
      problem("promises_for", fmt::format("there are no promises for '{}'", costs), "write percentile or typical");
    }
  }
  if (const Json* expected = member(value, "expected")) read_expected(*expected, plan);
}

void Reader::read_relaxed(const Json& parent, Plan& plan) {
  const Json* value = member(parent, "relaxed");
  if (!value || !object(*value, "relaxed", {"factor", "bounds"})) return;
  read_number(*value, "relaxed", "factor", plan.relax_factor);
  read_array(*value, "relaxed", "bounds", [&](const Json& element, const std::string& path) {
    if (!object(element, path, {"bound", "asked_ms", "planned_ms"})) return;
    RelaxedBound bound;
    bound.key = read_text(element, path, "bound");
    read_millis(element, path, "asked_ms", bound.asked);
    read_millis(element, path, "planned_ms", bound.planned);
    plan.relaxed.push_back(std::move(bound));
  });
}

void Reader::read_subchains(const Json& parent, Plan& plan) {
  plan.subchains.resize(app_.graph.subchains().size());
  each_subchain(parent, "", [&](const Json& element, const std::string& path, SubchainId id) {
    read_subchain(element, path, plan.subchains[id.index()]);
  });
}

void Reader::read_subchain(const Json& value, const std::string& path, SubchainPlan& subchain) {
  if (!object(value, path, {"cores", "period_ms", "execution_ms", "every", "share", "slice_ms", "threads"},
              {"wait_ms"}))
    return;
  read_array(value, path, "cores", [&](const Json& element, const std::string& here) {
    if (const auto core = whole(element, here)) subchain.cores.push_back(*core);
  });
  read_millis(value, path, "period_ms", subchain.period);
  read_millis(value, path, "execution_ms", subchain.execution);
  read_millis(value, path, "wait_ms", subchain.wait);
  read_every(value, path, subchain.every);
  read_number(value, path, "share", subchain.share);
  read_millis(value, path, "slice_ms", subchain.slice);
  read_int(value, path, "threads", subchain.threads);
}

void Reader::read_core(const Json& value, const std::string& path, Plan& plan) {
  CorePlan core;
  std::string form = "frames";
  if (value.is_object() && value.contains("form")) form = read_text(value, path, "form");
  if (form == "priorities") {
    if (!object(value, path, {"core", "form", "members"})) return;
    core.form = Form::kPriorities;
  } else {
    if (form != "frames")
      problem(child(path, "form"), fmt::format("there is no form '{}'", form), "write frames or priorities");
    if (!object(value, path, {"core", "frame_ms", "frame_min_ms", "frames", "slots", "idle_ms"}, {"form"})) return;
  }
  int number = -1;
  read_int(value, path, "core", number);
  if (value.contains("core") && number != static_cast<int>(plan.cores.size())) {
    problem(child(path, "core"), fmt::format("core {} stands where core {} belongs", number, plan.cores.size()),
            "list every core once, from 0 up");
  }
  read_millis(value, path, "frame_ms", core.frame);
  read_millis(value, path, "frame_min_ms", core.frame_min);
  const std::string frames = read_text(value, path, "frames");
  if (value.contains("frames") && frames != "elastic" && frames != "fixed") {
    problem(child(path, "frames"), fmt::format("there are no '{}' frames", frames), "write elastic or fixed");
  }
  core.frames = frames == "fixed" ? graph::FrameMode::kFixed : graph::FrameMode::kElastic;
  read_array(value, path, "slots", [&](const Json& e, const std::string& here) { read_slot(e, here, core); });
  read_millis(value, path, "idle_ms", core.idle);
  read_array(value, path, "members", [&](const Json& e, const std::string& here) { read_member(e, here, core); });
  plan.cores.push_back(std::move(core));
}

void Reader::read_slot(const Json& value, const std::string& path, CorePlan& core) {
  if (!object(value, path, {"subchain", "offset_ms", "slice_ms", "every", "phase"})) return;
  Slot slot;
  slot.subchain = subchain_named(value, path);
  read_millis(value, path, "offset_ms", slot.offset);
  read_millis(value, path, "slice_ms", slot.slice);
  read_every(value, path, slot.every);
  read_int(value, path, "phase", slot.phase);
  core.slots.push_back(slot);
}

void Reader::read_member(const Json& value, const std::string& path, CorePlan& core) {
  if (!object(value, path, {"subchain", "priority", "period_ms", "phase_ms", "budget_ms"},
              {"clock", "pause_ms", "after"})) {
    return;
  }
  Member member;
  member.subchain = subchain_named(value, path);
  read_int(value, path, "priority", member.priority);
  read_millis(value, path, "period_ms", member.period);
  read_millis(value, path, "phase_ms", member.phase);
  read_millis(value, path, "budget_ms", member.budget);
  if (value.contains("clock")) member.clock = node_named(value["clock"], child(path, "clock"));
  if (value.contains("pause_ms")) read_millis(value, path, "pause_ms", member.pause.emplace());
  if (const Json* after = this->member(value, "after")) read_after(*after, child(path, "after"), member);
  core.members.push_back(member);
}

void Reader::read_after(const Json& value, const std::string& path, Member& member) {
  if (!object(value, path, {"every"}, {"subchain", "node"})) return;
  if (value.contains("subchain") == value.contains("node")) {
    return problem(path, "it names either a subchain or a node");
  }
  After& after = member.after.emplace();
  if (value.contains("node")) {
    after.leader = node_named(value["node"], child(path, "node"));
  } else {
    after.leader = subchain_named(value, path);
  }
  read_int(value, path, "every", after.every);
}

// The one that the object names under `subchain`.
SubchainId Reader::subchain_named(const Json& parent, const std::string& path) {
  const std::string name = read_text(parent, path, "subchain");
  const auto id = app_.graph.find_subchain(name);
  if (parent.contains("subchain") && !id) {
    problem(child(path, "subchain"), fmt::format("app '{}' has no subchain '{}'", app_.name, name));
  }
  return id.value_or(SubchainId{});
}

void Reader::read_chain(const Json& value, const std::string& path, Plan& plan) {
  if (!object(value, path, {"path", "response_time_ms", "latency_ms", "period_ms", "weight"})) return;
  ChainPlan chain;
  read_array(value, path, "path",
             [&](const Json& e, const std::string& here) { chain.path.push_back(node_named(e, here)); });
  read_millis(value, path, "response_time_ms", chain.response);
  read_millis(value, path, "latency_ms", chain.latency);
  read_millis(value, path, "period_ms", chain.period);
  read_number(value, path, "weight", chain.weight);
  plan.chains.push_back(std::move(chain));
}

void Reader::read_node(const Json& value, const std::string& path, Plan& plan) {
  if (!object(value, path, {"node", "period_ms", "weight"})) return;
  NodePlan node;
  if (const Json* name = member(value, "node")) node.node = node_named(*name, child(path, "node"));
  read_millis(value, path, "period_ms", node.period);
  read_number(value, path, "weight", node.weight);
  plan.nodes.push_back(node);
}

void Reader::read_assumed(const Json& value, const std::string& path, Plan& plan) {
  if (!object(value, path, {"node", "cost_ms"})) return;
  AssumedCost assumed;
  if (const Json* name = member(value, "node")) assumed.node = node_named(*name, child(path, "node"));
  read_millis(value, path, "cost_ms", assumed.cost);
  plan.assumed.push_back(assumed);
}

void Reader::read_output(const Json& value, const std::string& path, Plan& plan) {
  if (!object(value, path, {"node", "runs_per_output"})) return;
  RunsPerOutput output;
  if (const Json* name = member(value, "node")) output.node = node_named(*name, child(path, "node"));
  read_number(value, path, "runs_per_output", output.runs);
  plan.outputs.push_back(output);
}

void Reader::read_batch(const Json& value, const std::string& path, Plan& plan) {
  if (!object(value, path, {"node", "items"})) return;
  Batch batch;
  if (const Json* name = member(value, "node")) batch.node = node_named(*name, child(path, "node"));
  read_int(value, path, "items", batch.items);
  plan.batches.push_back(batch);
}

void Reader::read_expected(const Json& value, Plan& plan) {
  const std::string path = "expected";
  if (!object(value, path, {"objective", "subchains", "chains"})) return;
  Expectation expected;
  read_number(value, path, "objective", expected.objective);
  expected.subchains.resize(app_.graph.subchains().size());
  each_subchain(value, path, [&](const Json& element, const std::string& here, SubchainId id) {
    if (!object(element, here, {"period_ms", "execution_ms"})) return;
    read_millis(element, here, "period_ms", expected.subchains[id.index()].period);
    read_millis(element, here, "execution_ms", expected.subchains[id.index()].execution);
  });
  read_array(value, path, "chains", [&](const Json& element, const std::string& here) {
    if (!object(element, here, {"response_time_ms", "latency_ms", "period_ms"})) return;
    Expectation::Chain& chain = expected.chains.emplace_back();
    read_millis(element, here, "response_time_ms", chain.response);
    read_millis(element, here, "latency_ms", chain.latency);
    read_millis(element, here, "period_ms", chain.period);
  });
  if (expected.chains.size() != plan.chains.size()) {
    problem("expected.chains",
            fmt::format("there are {}, and {} chains are planned", expected.chains.size(), plan.chains.size()));
  }
  plan.expected = std::move(expected);
}

}  // namespace

Result<Plan> from_json(std::string_view text, const graph::App& app, std::string_view file) {
  return Reader(app, file).read(text);
}

}  // namespace ctn::plan
