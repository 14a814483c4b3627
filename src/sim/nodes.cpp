#include "sim/nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <variant>

#include "base/mixed.h"
#include "record/input_edges.h"

namespace ctn::sim {
namespace {

int threads_of_node(const graph::Node& node, int cores) {
  if (node.external) return 0;
  return std::max(1, std::min(node.max_threads, cores));
}

bool has_age_limits(const graph::Graph& graph) {
  return std::any_of(graph.edges().begin(), graph.edges().end(),
                     [](const graph::Edge& edge) { return edge.age_limit.has_value(); });
}

}  // namespace

std::size_t Nodes::threads_needed(const graph::App& app, int cores) {
  std::size_t threads = 0;
  for (const graph::Node& node : app.graph.nodes()) threads += static_cast<std::size_t>(threads_of_node(node, cores));
  return threads;
}

Nodes::Nodes(const graph::App& app, const Machine& machine, const policy::CpuKinds& kinds, RunCosts& costs, Cpus& cpus,
             Cpus::Thread first, Client& client)
    : app_(app),
      kinds_(kinds),
      costs_(costs),
      cpus_(cpus),
      first_(first),
      client_(client),
      overhead_(machine.costs.run_overhead),
      jitter_(machine.costs.run_jitter),
      real_time_(machine.real_time),
      ages_(app.graph),
      batches_(app.graph),
      follows_ages_(has_age_limits(app.graph)),
      nodes_(app.graph.nodes().size()),
      exclusions_(app.exclusive.size()),
      signals_(app.graph.subchains().size()),
      outputs_of_subchains_(signals_.size()),
      outputs_of_nodes_(nodes_.size()) {
  Cpus::Thread thread = first;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    Node& node = nodes_[index];
    node.id = NodeId(index);
    node.described = &app.graph.nodes()[index];
    node.subchain = node.described->subchain;
    node.thread = thread;
    const int threads = threads_of_node(*node.described, machine.cores);
    node.helpers = std::max(threads - 1, 0);
    node.used_before.resize(static_cast<std::size_t>(threads));
    node_of_.insert(node_of_.end(), static_cast<std::size_t>(threads), index);
    thread += static_cast<Cpus::Thread>(threads);
    for (const NodeId predecessor : node.described->predecessors) {
      nodes_[predecessor.index()].outputs.push_back({index, node.inputs.size()});
      node.inputs.push_back(
          {.predecessor = predecessor.index(), .queue = node.described->input == graph::InputKind::kQueue});
    }
    node.channels.resize(node.inputs.size());
    node.edges = record::input_edges(app.graph, node.id);
    node.awaits_input = app.graph.awaits_input(node.id);
    if (node.described->follows) {
      nodes_[node.described->follows->index()].followers.push_back(index);
    } else if (node.described->unscheduled) {
      node.period = node.described->period;
    }
    node.run.node = node.id;
  }
  for (const graph::Subchain& subchain : app.graph.subchains()) {
    for (std::size_t i = 0; i + 1 < subchain.nodes.size(); ++i) {
      nodes_[subchain.nodes[i].index()].next = subchain.nodes[i + 1].index();
    }
  }
}

void Nodes::start(const os::CpuSet& cpus, os::Level scheduled, os::Level unscheduled, const std::vector<Ticks>& timers,
                  const std::vector<Ticks>& clocks) {
  const CpuMask mask(cpus);
  for (Node& node : nodes_) {
    if (node.described->external) continue;
    for (int helper = 0; helper <= node.helpers; ++helper) {
      const Cpus::Thread thread = node.thread + static_cast<Cpus::Thread>(helper);
      cpus_.set_cpus(thread, mask);
      set_level_of(node, helper, level_of(node.described->unscheduled ? unscheduled : scheduled));
    }
    for (const NodeId from : node.described->predecessors) {
      if (node.awaits_input && app_.graph.node(from).is_external_clock()) node.clocks.push_back(clocks[from.index()]);
    }
    if (!node.period) continue;
    node.period = timers[node.id.index()].period;
    node.next_begin = timers[node.id.index()].tick;
    cpus_.wake_at(node.thread, node.next_begin);
  }
}

// --- Triggers ---

void Nodes::trigger(SubchainId subchain, std::uint64_t number, int from_cpu) {
  wake(nodes_[app_.graph.subchain(subchain).head().index()], number, from_cpu);
}

void Nodes::wake(Node& node, std::uint64_t token, int from_cpu) {
  node.word = token;
  if (node.busy) return;
  node.busy = true;
  cpus_.wake(node.thread, from_cpu);
}

Outputs& Nodes::outputs(const plan::Leader& leader) {
  if (const SubchainId* const subchain = std::get_if<SubchainId>(&leader)) {
    return outputs_of_subchains_[subchain->index()];
  }
  return outputs_of_nodes_[std::get<NodeId>(leader).index()];
}

void Nodes::give_output(const plan::Leader& leader, int from_cpu) {
  Outputs& given = outputs(leader);
  ++given.count;
  given.newest = cpus_.now();
  for (const auto& [controller, count] : given.subscribers) {
    if (given.count >= count) client_.wake(controller, from_cpu);
  }
}

void Nodes::complete(SubchainId subchain, std::uint64_t token, int from_cpu) {
  Signal& signal = signals_[subchain.index()];
  signal.completed = std::max(signal.completed, token);
  if (signal.wants_completions && signal.holder) client_.wake(*signal.holder, from_cpu);
}

// --- Runs ---

Nanos Nodes::begin(Cpus::Thread thread, int cpu) {
  Node& node = nodes_[node_of_[thread - first_]];
  if (thread != node.thread) return node.share;
  if (node.rest > Nanos{0}) return std::exchange(node.rest, Nanos{0});
  node.waits_for_news = lacks_input(node);
  if (node.waits_for_news || !enter(node)) return Nanos{0};
  begin_run(node, cpu);
  return until_wait(node);
}

// What of its share the first thread works before it waits.
Nanos Nodes::until_wait(Node& node) {
  if (node.wait == Nanos{0}) return node.share;
  node.rest = std::max(node.share / 2, Nanos{1});
  return node.share - node.rest;
}

bool Nodes::done(Cpus::Thread thread, int cpu) {
  Node& node = nodes_[node_of_[thread - first_]];
  if (thread == node.thread && node.wait > Nanos{0}) {
    cpus_.wake_at(thread, cpus_.now() + std::exchange(node.wait, Nanos{0}));
    return false;
  }
  // It asked for input, or its exclusive group; by now that may be its own.
  if (thread == node.thread && node.working == 0) return !sleeps_for_input(node) && !waits_for_exclusion(node);
  if (--node.working > 0) return false;  // the thread that works longest ends the run
  end_run(node, cpu);
  leave(node, cpu);
  if (node.period) {
    node.next_begin = std::max(node.next_begin + *node.period, cpus_.now());
    cpus_.wake_at(node.thread, node.next_begin);
    return false;
  }
  node.busy = node.word != node.token;
  if (thread == node.thread) return node.busy;
  if (node.busy) cpus_.wake(node.thread, cpu);
  return false;
}

bool Nodes::lacks_input(const Node& node) const {
  if (!node.awaits_input || node.has_news) return false;
  const TimePoint last_begin = node.run.number == 0 ? TimePoint::min() : node.run.begin;
  return std::none_of(node.clocks.begin(), node.clocks.end(),
                      [&](const Ticks& clock) { return clock.last(cpus_.now()) > last_begin; });
}

// Whether its thread is to sleep until there is input.
bool Nodes::sleeps_for_input(Node& node) {
  if (!node.waits_for_news) return false;
  node.waits_for_news = lacks_input(node);
  if (!node.waits_for_news || node.clocks.empty()) return node.waits_for_news;
  TimePoint tick = kNever;
  for (const Ticks& clock : node.clocks) tick = std::min(tick, clock.next(cpus_.now() + Nanos{1}));
  cpus_.wake_at(node.thread, tick);
  return true;
}

void Nodes::tell_news(Node& consumer, int cpu) {
  if (!consumer.awaits_input) return;
  consumer.has_news = true;
  if (std::exchange(consumer.waits_for_news, false)) cpus_.wake(consumer.thread, cpu);
}

int Nodes::threads_planned(const Node& node) const {
  if (node.helpers == 0) return 1;
  const int planned = node.subchain ? signals_[node.subchain->index()].threads : 0;
  const int wanted = planned > 0 ? std::min(planned, node.described->max_threads) : node.described->max_threads;
  return std::min(wanted, node.helpers + 1);
}

void Nodes::begin_run(Node& node, int cpu) {
  node.token = node.word;
  node.has_news = false;
  ++node.run.number;
  node.run.begin = cpus_.now();
  node.run.threads = threads_planned(node);
  node.threads = costs_.threads_used(node.id, node.run.threads);
  const model::RunDraw draw =
      costs_.draw(node.id, node.run.number, cpus_.now().time_since_epoch(), node.threads, kinds_.of(cpu));
  node.run.mode = static_cast<std::uint32_t>(draw.mode);
  node.wait = node.run.wait = draw.wait;
  node.working = node.threads;
  consume(node);
  node.share = share_of(node, draw, cpu) + overhead_ + jitter_of(node.run);
  node.run.elapsed = node.run.threads > 1 ? node.share : Nanos{0};
  for (int helper = 0; helper < node.threads; ++helper) {
    const Cpus::Thread thread = node.thread + static_cast<Cpus::Thread>(helper);
    node.used_before[static_cast<std::size_t>(helper)] = cpus_.used_by(thread);
    if (helper > 0) cpus_.wake(thread, cpu);
  }
}

Nanos Nodes::share_of(Node& node, const model::RunDraw& draw, int cpu) {
  const RunAccess::Charge charge = node.body ? RunAccess::take_charge(node.seen) : RunAccess::Charge{};
  check_charge(node, charge);
  const std::size_t items = batches_.taken_by(node.run);
  if (!charge.cpu) return draw.cpu_with(items);
  node.run.mode = RunAccess::mode(node.seen);
  return costs_.share_of_charge(node.id, *charge.cpu, node.threads, kinds_.of(cpu));
}

void Nodes::check_charge(const Node& node, const RunAccess::Charge& charge) {
  if (charge.refused < Nanos{0}) {
    tell_mistake(node, fmt::format("charged {} ns", charge.refused.count()), "charge CPU time from 0 up");
  } else if (!charge.cpu && !costs_.knows(node.id)) {
    tell_mistake(node, "has no cost",
                 fmt::format("call Run::charge() in each run of {0}, or say in a cost file what they cost, as in {0}: "
                             "1.2ms",
                             node.described->name));
  }
  const std::size_t modes = std::max<std::size_t>(node.described->modes.size(), 1);
  if (charge.cpu && RunAccess::mode(node.seen) >= modes) {
    tell_mistake(node, fmt::format("is in mode {}, which the app does not have", RunAccess::mode(node.seen)),
                 fmt::format("call set_mode() with a number below {}, or add modes to the node", modes));
  }
}

void Nodes::tell_mistake(const Node& node, std::string_view what, std::string hint) {
  client_.mistaken(
      {{}, {}, fmt::format("run {} of node {} {}", node.run.number, node.described->name, what), std::move(hint)});
}

// Evenly spread, and the same for equal runs of equal nodes.
Nanos Nodes::jitter_of(const record::Run& run) const {
  return jitter_ == Nanos{0} ? Nanos{0} : chance_below(jitter_, run.number, run.node.index());
}

void Nodes::consume(Node& node) {
  const bool has_code = node.body || node.effect;
  if (has_code) {
    RunAccess::reset(node.seen, node.run.number, node.inputs.size());
    RunAccess::set_node(node.seen, node.id);
    RunAccess::set_threads(node.seen, node.working);
    RunAccess::begin(node.seen, node.run.begin, node.edges);
    for (std::size_t index = 0; index < node.inputs.size(); ++index) {
      const std::optional<TimePoint> taken = ages_.taken(node.id, index);
      if (taken) RunAccess::set_taken_before(node.seen, index, taken->time_since_epoch());
    }
  }
  node.run.consumed.clear();
  for (std::size_t index = 0; index < node.inputs.size(); ++index) {
    if (!node.body || !node.inputs[index].has_channel) consume_newest(node, index);
  }
  if (node.body) {
    RunAccess::take_limited(node.seen);
    node.body(node.seen);
    for (std::size_t index = 0; index < node.inputs.size(); ++index) {
      if (!node.inputs[index].has_channel) continue;
      const RunAccess::Input& taken = RunAccess::inputs(node.seen)[index];
      if (taken.first != 0) {
        node.run.consumed.push_back({NodeId(node.inputs[index].predecessor), taken.first, taken.last});
      }
    }
  }
  if (follows_ages_) ages_.set_ages(node.run);
}

void Nodes::consume_newest(Node& node, std::size_t index) {
  Input& input = node.inputs[index];
  if (input.newest == 0) return;
  const std::uint64_t before = std::exchange(input.taken, input.newest);
  input.waiting = 0;
  if (input.queue && input.newest <= before) return;
  const record::Consumed consumed{NodeId(input.predecessor), input.queue ? before + 1 : input.newest, input.newest};
  node.run.consumed.push_back(consumed);
  if (!node.body && !node.effect) return;
  if (const auto origin = ages_.origin(node.id, index, consumed.first, consumed.last)) {
    RunAccess::consume(node.seen, index, consumed.first, consumed.last, origin->time_since_epoch());
  }
}

// So that it gives no output.
bool Nodes::is_stale(const Node& node) {
  for (std::size_t index = 0; index < node.edges.size(); ++index) {
    if (node.edges[index].skips && node.run.ages[index] > node.edges[index].max_age) return true;
  }
  return false;
}

// At its first run, and then on average once a period, as long as it runs at least that often.
bool Nodes::output_due(Node& node) {
  if (!node.described->output_period) return true;
  const TimePoint now = cpus_.now();
  if (node.next_output && now < *node.next_output) return false;
  node.next_output = std::max(node.next_output.value_or(now) + *node.described->output_period, now);
  return true;
}

void Nodes::end_run(Node& node, int cpu) {
  node.run.end = cpus_.now();
  node.run.cpu = Nanos{0};
  for (int helper = 0; helper < node.threads; ++helper) {
    const Cpus::Thread thread = node.thread + static_cast<Cpus::Thread>(helper);
    node.run.cpu += cpus_.used_by(thread) - node.used_before[static_cast<std::size_t>(helper)];
  }
  node.run.on_cpu = cpu;
  if (node.effect) {
    node.effect(node.seen);
    const RunAccess::Charge late = RunAccess::take_charge(node.seen);
    if (late.cpu || late.refused < Nanos{0}) {
      tell_mistake(node, "was charged in on_effect()'s function, when it had ended", "charge it in node()'s function");
    }
  }
  const bool has_code = node.body || node.effect;
  const bool skips = is_stale(node) || (has_code && !RunAccess::emits(node.seen));
  // A function says itself which runs give an output, as in a session; `output_period` stands in where there is none.
  node.run.emitted = !skips && (node.body || output_due(node));
  const TimePoint origin = follows_ages_ ? ages_.add(node.run) : node.run.begin;
  if (has_code) {
    if (!node.run.emitted) node.seen.skip_output();
    RunAccess::finish_writes(node.seen, origin.time_since_epoch());
  }
  batches_.ended(node.run);
  client_.run_ended(node.run);
  if (node.run.emitted) publish(node, cpu);
  pass_on(node, node.run.emitted, cpu);
}

void Nodes::publish(Node& node, int cpu) {
  for (const Output& output : node.outputs) {
    Node& consumer = nodes_[output.node];
    tell_news(consumer, cpu);
    Input& input = consumer.inputs[output.input];
    if (consumer.body && input.has_channel) continue;  // the channel itself counts what waits, and what is lost
    if (input.queue && input.waiting == QueueChannel<int>::kCapacity) {
      ++dropped_;
      continue;
    }
    ++input.waiting;
    input.newest = node.run.number;
  }
}

void Nodes::pass_on(Node& node, bool emits, int cpu) {
  if (node.next && emits) {
    wake(nodes_[*node.next], node.token, cpu);
  } else if (node.subchain) {
    if (emits) give_output(*node.subchain, cpu);
    complete(*node.subchain, node.token, cpu);
  } else if (emits) {
    for (const std::size_t follower : node.followers) wake(nodes_[follower], node.run.number, cpu);
    give_output(node.id, cpu);
  }
}

}  // namespace ctn::sim
