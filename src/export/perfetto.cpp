#include "export/perfetto.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "export/in_force.h"
#include "export/responses.h"
#include "export/slice_row.h"
#include "export/trace_writer.h"
#include "record/app_changes.h"

namespace ctn::exports {
namespace {

constexpr std::size_t kMaxLanes = 8;
constexpr int kRowsOfCore = static_cast<int>(kMaxLanes) + 2;
constexpr std::uint64_t kMaxFlows = 4096;  // of one run over one edge
constexpr int kSteps = 3;                  // that take long

using record::Consumed;
using record::Consumer;
using record::Run;
using Event = TraceWriter::Event;

// Which subchains own a core or have a fixed priority: their runs show what had the core. Where subchains take turns in
// frames, the record's slots show it.
std::vector<int> cores_by_runs(const plan::Plan& plan, SubchainId id) {
  if (id.index() >= plan.subchains.size()) return {};
  std::vector<int> cores = plan.subchains[id.index()].cores;
  std::erase_if(cores, [&](int core) {
    return core < 0 || static_cast<std::size_t>(core) >= plan.cores.size() ||
           !plan.cores[static_cast<std::size_t>(core)].slots.empty();
  });
  return cores;
}

// Arrows from a run to the runs that took it as input. Both ends compute the same id on their own: an input that is
// *latest* takes one run, and a run of a queue is taken once.
class Flows {
 public:
  explicit Flows(const graph::Graph& graph) : graph_(&graph) {
    for (std::size_t i = 0; i < graph.edges().size(); ++i) edges_[{graph.edges()[i].from, graph.edges()[i].to}] = i;
  }

  void add(const Run& run, std::span<const Consumer> consumers, Event event) const {
    for (const Consumer& consumer : consumers) {
      if (const auto edge = find(run.node, consumer.node)) event.begin_flow(id(*edge, run.number, consumer.run));
    }
    for (const Consumed& input : run.consumed) {
      const auto edge = find(input.predecessor, run.node);
      if (!edge) continue;
      const std::uint64_t max = takes_all(run.node) ? kMaxFlows : 1;
      const std::uint64_t first = input.last - input.first < max ? input.first : input.last - max + 1;
      for (std::uint64_t number = first; number <= input.last; ++number) event.end_flow(id(*edge, number, run.number));
    }
  }

 private:
  static constexpr int kNumberBits = 44;

  bool takes_all(NodeId node) const { return graph_->node(node).input == graph::InputKind::kQueue; }
  std::optional<std::size_t> find(NodeId from, NodeId to) const {
    const auto found = edges_.find({from, to});
    return found == edges_.end() ? std::nullopt : std::optional(found->second);
  }
  std::uint64_t id(std::size_t edge, std::uint64_t producer, std::uint64_t consumer) const {
    const std::uint64_t number = takes_all(graph_->edges()[edge].to) ? producer : consumer;
    return (static_cast<std::uint64_t>(edge + 1) << kNumberBits) + number;
  }

  const graph::Graph* graph_;
  std::map<std::pair<NodeId, NodeId>, std::size_t> edges_;
};

class Export {
 public:
  Export(const record::Reader& record, const Sink& sink, const Progress& progress)
      : record_(record),
        app_(record.app()),
        started_(record.header().started),
        ended_(std::max(record.ending().ended, started_)),
        progress_(progress),
        trace_(sink, started_) {}

  Status run() {
    add_tracks();
    using Step = Status (Export::*)();
    for (const Step step : {&Export::write_events, &Export::write_nodes, &Export::write_slots, &Export::write_cores,
                            &Export::write_triggers, &Export::write_measured}) {
      if (Status done = (this->*step)(); !done) return done;
    }
    return trace_.finish();
  }

 private:
  // What had a core. Rows that have nothing in them are not made.
  struct Core {
    std::optional<SliceRow> slots;
    std::optional<SliceRow> stolen;
    std::optional<SliceRow> runs;
  };
  struct ChainTracks {
    Track measured;
    Track promised;
    Track expected;
    Track bound;
  };
  struct SubchainTracks {
    Track measured;
    Track planned;
  };

  void add_tracks() {
    const std::string title = fmt::format("{} under {}", app_.name, record_.header().scheduler);
    root_ = trace_.add_track(title, std::nullopt);
    describe_record(trace_.begin_slice(root_, started_, title));
    trace_.end_slice(root_, ended_);
    plans_.emplace(trace_, "plans", root_);
    notices_ = trace_.add_track("notices", root_);
    changes_ = trace_.add_track("changes", root_);
    cores_track_ = trace_.add_track("cores", root_);
    add_node_tracks();
    add_counters();
  }

  void describe_record(Event event) const {
    const record::Header& header = record_.header();
    event.text("note", header.note).text("started_utc", header.host.utc).text("kernel", header.host.kernel);
    event.text("cpu_model", header.host.cpu_model)
        .text("cpus", os::to_string(header.cpus))
        .flag("real_time", header.real_time);
    event.ms("warm_up_ms", header.warm_up).flag("complete", record_.ending().closed);
  }

  // Nodes stand below their subchain, unscheduled ones by themselves.
  void add_node_tracks() {
    const std::span<const graph::Node> nodes = app_.graph.nodes();
    std::vector<std::optional<SliceRow>> rows(nodes.size());
    const Track subchains = trace_.add_track("subchains", root_);
    for (const graph::Subchain& subchain : app_.graph.subchains()) {
      triggers_.emplace_back(trace_, subchain.name, subchains, kMaxLanes);
      for (const NodeId node : subchain.nodes) {
        node_rows_.emplace(node, SliceRow(trace_, app_.graph.node(node).name, triggers_.back().track()));
      }
    }
    const Track unscheduled = trace_.add_track("unscheduled nodes", root_);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!nodes[i].unscheduled) continue;
      node_rows_.emplace(NodeId{i}, SliceRow(trace_, nodes[i].name, unscheduled));
    }
  }

  void add_counters() {
    const Track responses = trace_.add_track("response times", root_);
    for (const graph::Term& term : app_.objective) {
      if (term.metric != graph::Metric::kResponseTime) continue;
      const Track chain = trace_.add_track(app_.graph.path_name(term.path), responses);
      chains_.push_back({trace_.add_counter("measured", chain), trace_.add_counter("promised", chain),
                         trace_.add_counter("expected", chain), trace_.add_counter("bound", chain)});
    }
    const Track compute = trace_.add_track("compute times", root_);
    for (const graph::Subchain& subchain : app_.graph.subchains()) {
      const Track all = trace_.add_track(subchain.name, compute);
      subchains_.push_back({trace_.add_counter("measured", all), trace_.add_counter("planned", all)});
      if (subchain.nodes.size() == 1) continue;  // the node's would be the same
      for (const NodeId node : subchain.nodes) {
        node_costs_.emplace(node, trace_.add_counter(app_.graph.node(node).name, all));
      }
    }
    for (std::size_t i = 0; i < app_.graph.nodes().size(); ++i) {
      const graph::Node& node = app_.graph.nodes()[i];
      if (node.unscheduled) node_costs_.emplace(NodeId{i}, trace_.add_counter(node.name, compute));
    }
  }

  // Plans with their contents, changes, notices.
  Status write_events() {
    auto in_force = InForce::at_start(record_);
    if (!in_force) return in_force.error();
    for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
      if (const auto bound = in_force->bound_ms(chain)) trace_.add_count(chains_[chain].bound, started_, *bound);
    }
    for (std::size_t i = 0; i < in_force->plans().size(); ++i) {
      const record::PlanChange& change = in_force->plans()[i];
      const bool last = i + 1 == in_force->plans().size();
      const TimePoint until = last ? std::max(change.at, ended_) : in_force->plans()[i + 1].at;
      if (Status done = in_force->move_to(change.at); !done) return done;
      if (until < change.at || !in_force->plan()) continue;
      describe_plan(plans_->add(change.at, until, change.reason), i + 1, *in_force->plan());
      write_planned(change.at, *in_force);
    }
    plans_->finish();
    return write_changes(*in_force);
  }

  static void describe_plan(Event event, std::size_t number, const plan::Plan& plan) {
    event.number("number", number).text("planner", plan.planner).real("objective_ms", plan.objective);
    event.real("relax_factor", plan.relax_factor).text("promises_for", plan::promises_for(plan.for_typical));
    for (const plan::RelaxedBound& bound : plan.relaxed) {
      event.text("relaxed", fmt::format("{}: {:.4g} ms in place of {:.4g}", bound.key, bound.planned.count(),
                                        bound.asked.count()));
    }
  }

  void write_planned(TimePoint at, const InForce& in_force) {
    for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
      const auto predicted = in_force.predicted(chain);
      if (!predicted) continue;
      trace_.add_count(chains_[chain].promised, at, predicted->promised_response_ms);
      trace_.add_count(chains_[chain].expected, at, predicted->response_ms);
    }
    const std::vector<plan::SubchainPlan>& planned = in_force.plan()->subchains;
    for (std::size_t i = 0; i < std::min(planned.size(), subchains_.size()); ++i) {
      if (planned[i].share > 0.0)
        trace_.add_count(subchains_[i].planned, at, (planned[i].slice / planned[i].share).count());
    }
  }

  Status write_changes(const InForce& in_force) {
    for (const record::AppChange& change : in_force.changes()) {
      trace_.add_instant(changes_, change.at, record::describe(app_, change));
      if (change.what != record::AppChange::What::kMax) continue;
      const auto chain = in_force.chain_of(change.item);
      if (chain) trace_.add_count(chains_[*chain].bound, change.at, change.after.value_or(0.0));
    }
    const auto costs = record_.cost_changes();
    if (!costs) return costs.error();
    for (const record::CostChange& change : *costs) {
      const graph::Node& node = app_.graph.node(change.node);
      Event event = trace_.add_instant(changes_, change.at, "compute time of " + node.name);
      event.text("mode", mode_name(node, change.mode)).ms("before_ms", change.before).ms("after_ms", change.after);
      event.number("runs", change.runs);
    }
    const auto notices = record_.notices();
    if (!notices) return notices.error();
    for (const record::Notice& notice : *notices) {
      trace_.add_instant(notices_, notice.at, notice.kind).text("detail", notice.detail);
    }
    return Done{};
  }

  static std::string mode_name(const graph::Node& node, std::uint32_t mode) {
    return mode < node.modes.size() ? node.modes[mode] : fmt::format("{}", mode);
  }

  Status write_nodes() {
    const Flows flows(app_.graph);
    const double nodes = static_cast<double>(app_.graph.nodes().size());
    const Status done = record_.each_run_with_consumers([&](const Run& run, std::span<const Consumer> consumers) {
      const auto row = node_rows_.find(run.node);
      if (row == node_rows_.end()) return;  // an external node
      const graph::Node& node = app_.graph.node(run.node);
      Event event = row->second.add(run.begin, run.end, node.name);
      event.number("number", run.number).ms("cpu_ms", run.cpu).flag("emitted", run.emitted);
      if (run.wait > Nanos{0}) event.ms("wait_ms", run.wait);
      if (run.on_cpu >= 0) event.number("on_cpu", static_cast<std::uint64_t>(run.on_cpu));
      if (!node.modes.empty()) event.word("mode", mode_name(node, run.mode));
      flows.add(run, consumers, event);
      tell(0, static_cast<double>(run.node.index()) / nodes);
    });
    for (auto& [node, row] : node_rows_) row.finish();
    return done;
  }

  SliceRow& row_of(int core, std::optional<SliceRow> Core::*which, const char* name, int rank, std::size_t lanes = 1) {
    std::optional<SliceRow>& row = cores_[core].*which;
    if (!row)
      row.emplace(trace_, fmt::format("core {}: {}", core, name), cores_track_, lanes, core * kRowsOfCore + rank);
    return *row;
  }

  Status write_slots() {
    Status done = record_.each_slot([this](const record::SlotUse& slot) {
      SliceRow& row = row_of(slot.core, &Core::slots, "slots", 0);
      Event event = row.add(slot.begin, std::max(slot.begin, slot.end), app_.graph.subchain(slot.subchain).name);
      event.ms("late_ms", slot.begin - slot.planned);
    });
    if (!done) return done;
    return record_.each_steal([this](const record::Steal& steal) {
      SliceRow& row = row_of(steal.core, &Core::stolen, "stolen", 1);
      Event event = row.add(steal.begin, std::max(steal.begin, steal.end), app_.graph.subchain(steal.thief).name);
      event.word("from", app_.graph.subchain(steal.victim).name);
    });
  }

  Status write_cores() {
    auto in_force = InForce::at_start(record_);
    if (!in_force) return in_force.error();
    Status status = Done{};
    const auto take = [&](const Run& run) {
      const std::optional<SubchainId> subchain = app_.graph.node(run.node).subchain;
      if (status) status = in_force->move_to(run.begin);
      if (!status || !subchain || !in_force->plan()) return;
      for (const int core : cores_by_runs(*in_force->plan(), *subchain)) {
        SliceRow& row = row_of(core, &Core::runs, "runs", 2, kMaxLanes);
        Event event = row.add(run.begin, run.end, app_.graph.node(run.node).name);
        event.number("number", run.number);
      }
      tell(1, run.begin);
    };
    const Status done = in_force->plans().empty() ? Status(Done{}) : record_.each_run_by_begin(take);
    for (auto& [number, core] : cores_) {
      for (std::optional<SliceRow>* row : {&core.slots, &core.stolen, &core.runs}) {
        if (*row) (*row)->finish();
      }
    }
    return done ? status : done;
  }

  Status write_triggers() {
    Status done = record_.each_trigger([this](const record::Trigger& trigger) {
      const auto [begin, end] = std::minmax(trigger.due, trigger.sent);
      Event event = triggers_[trigger.subchain.index()].add(begin, end, "trigger");
      event.number("number", trigger.number).ms("late_ms", trigger.sent - trigger.due);
    });
    for (SliceRow& row : triggers_) row.finish();
    if (!done) return done;
    return record_.each_overrun([this](const record::Overrun& overrun) {
      Event event = trace_.add_instant(triggers_[overrun.subchain.index()].track(), overrun.at, "overrun");
      event.number("number", overrun.number).ms("cpu_ms", overrun.cpu);
    });
  }

  // What the newest runs of a subchain's nodes took together.
  Status write_measured() {
    std::vector<Nanos> newest(app_.graph.nodes().size());
    const auto take_run = [&](const Run& run) {
      newest[run.node.index()] = run.cpu;
      const auto cost = node_costs_.find(run.node);
      if (cost != node_costs_.end()) trace_.add_count(cost->second, run.end, to_millis(run.cpu).count());
      const std::optional<SubchainId> id = app_.graph.node(run.node).subchain;
      if (id && app_.graph.subchain(*id).tail() == run.node) {
        Nanos sum{0};
        for (const NodeId node : app_.graph.subchain(*id).nodes) sum += newest[node.index()];
        trace_.add_count(subchains_[id->index()].measured, run.end, to_millis(sum).count());
      }
      tell(2, run.end);
    };
    return each_response(record_, take_run, [&](std::size_t chain, const record::ChainSample& sample) {
      if (!sample.response) return;
      trace_.add_count(chains_[chain].measured, sample.end, to_millis(*sample.response).count());
    });
  }

  void tell(int step, double part) {
    if (++told_ % 4096 == 0) progress_((step + std::clamp(part, 0.0, 1.0)) / kSteps);
  }
  void tell(int step, TimePoint at) {
    const Millis whole = ended_ - started_;
    tell(step, whole > Millis{0} ? Millis{at - started_} / whole : 1.0);
  }

  const record::Reader& record_;
  const graph::App& app_;
  TimePoint started_;
  TimePoint ended_;
  const Progress& progress_;
  std::uint64_t told_ = 0;
  TraceWriter trace_;
  Track root_{};
  std::optional<SliceRow> plans_;
  Track notices_{};
  Track changes_{};
  Track cores_track_{};
  std::map<int, Core> cores_;             // by number
  std::vector<SliceRow> triggers_;        // by SubchainId
  std::map<NodeId, SliceRow> node_rows_;  // of all but external ones
  std::vector<ChainTracks> chains_;
  std::vector<SubchainTracks> subchains_;  // by SubchainId
  std::map<NodeId, Track> node_costs_;
};

}  // namespace

Status write_perfetto(const record::Reader& record, const Sink& sink, const Progress& progress) {
  return Export(record, sink, progress).run();
}

}  // namespace ctn::exports
