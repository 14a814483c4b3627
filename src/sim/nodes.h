// The app's nodes as the runtime has them (runtime/node_port.h, node_threads.h): a thread a node, which sleeps until a
// trigger comes, takes its inputs, works, and hands on. A trigger carries the number of the subchain's trigger that it
// goes back to; one that comes while the node is busy replaces what waits. The tail, or a node that gives no output,
// says that the subchain's run has ended. An unscheduled node has a timer, or is set off by the output of the node that
// it follows.
//
// Each run says how old its inputs are (record/ages.h), and gives no output where it says so in the app.
//
// A run of a queue node costs what its batch adds, by the items that it consumed when it began. A run that its function
// charges (Run::charge()) costs that alone, shared evenly by its threads, and is in the mode that the function says;
// what it waits is drawn all the same.
//
// A run that works on several threads does so as `catan run --synthetic` would: each burns the same, and the run ends
// with the last of them. A run that waits has its first thread sleep in the middle of its work.
//
// A run of a node that needs input, triggered without, begins when a predecessor has given some or a clock of one has
// ticked: its thread sleeps until then, and holds no exclusive group.
//
// A run of a node in an exclusive group begins when no other of that group is under way: its thread sleeps until then,
// and raises the one that it waits for to its own level. A thread with a reservation is not raised.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/run_access.h"
#include "catan/channel.h"
#include "catan/run.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "policy/assignment.h"
#include "policy/batch_sizes.h"
#include "policy/cpu_kinds.h"
#include "record/ages.h"
#include "record/events.h"
#include "sim/cpus.h"
#include "sim/machine.h"
#include "sim/reservation.h"
#include "sim/run_costs.h"

namespace ctn::sim {

using Body = std::function<void(Run&)>;

// Of a subchain's tail, or of an unscheduled node, for the controllers that follow them.
struct Outputs {
  struct Subscriber {
    std::size_t controller = 0;
    std::uint64_t count = 0;  // from which on it is woken at each
  };

  std::uint64_t count = 0;
  TimePoint newest{};
  std::vector<Subscriber> subscribers;
};

// Between a subchain's nodes and the controller that holds it.
struct Signal {
  std::uint64_t completed = 0;  // the newest trigger whose run has ended
  std::optional<std::size_t> holder;
  bool wants_completions = false;
  int threads = 0;  // on how many a node's run should work; 0: no plan says
};

class Nodes {
 public:
  // What nodes do is told to it.
  class Client {
   public:
    virtual ~Client() = default;
    virtual void run_ended(const record::Run& run) = 0;  // good for the call
    // A function made a mistake, so that nothing of what follows would be right. There may be more at the same time.
    virtual void mistaken(Problem problem) = 0;
    virtual void wake(std::size_t controller, int from_cpu) = 0;
  };

  // How many threads they need in all.
  static std::size_t threads_needed(const graph::App& app, int cores);

  // Its threads are `first` and those that follow. All outlive it.
  Nodes(const graph::App& app, const Machine& machine, const policy::CpuKinds& kinds, RunCosts& costs, Cpus& cpus,
        Cpus::Thread first, Client& client);

  // --- before anything runs ---
  void set_body(NodeId node, Body body) {
    nodes_[node.index()].body = std::move(body);
    follows_ages_ = true;
  }
  void set_effect(NodeId node, Body effect) {
    nodes_[node.index()].effect = std::move(effect);
    follows_ages_ = true;
  }
  // Runs of `consumer` consume over that input what its function reads there.
  void use_channel(NodeId consumer, std::size_t input, ChannelBase& channel) {
    nodes_[consumer.index()].inputs[input].has_channel = true;
    nodes_[consumer.index()].edges[input].channel = &channel;
  }
  // By NodeId: where a node has a reservation, its threads get that whenever they would be given a level.
  void reserve(std::vector<Reservation> reservations) { reservations_ = std::move(reservations); }
  // The channel of the edge; null where there is no such edge between nodes of ours.
  template <class C>
  C* channel(NodeId from, NodeId to);
  // Places all threads, and sets the timers of unscheduled nodes going (`timers`: by NodeId, those of nodes that follow
  // no other).
  // `clocks`: by NodeId, those of external nodes that have one.
  void start(const os::CpuSet& cpus, os::Level scheduled, os::Level unscheduled, const std::vector<Ticks>& timers,
             const std::vector<Ticks>& clocks);

  // --- by controllers ---
  Signal& signal(SubchainId subchain) { return signals_[subchain.index()]; }
  Outputs& outputs(const plan::Leader& leader);
  void trigger(SubchainId subchain, std::uint64_t number, int from_cpu);
  void set_level(SubchainId subchain, os::Level level);
  // As the place says, or its nodes' reservations: where a node has several threads, each has it for itself.
  void set_levels(SubchainId subchain, const policy::SubchainPlace& place);
  void move(SubchainId subchain, const os::CpuSet& cpus);
  // That all its threads have used so far.
  Nanos cpu_time(SubchainId subchain);
  // Of all nodes that run by themselves.
  void set_level_of_unscheduled(os::Level level);

  // --- by the CPUs' client; threads counted from `first` ---
  Nanos begin(Cpus::Thread thread, int cpu);
  bool done(Cpus::Thread thread, int cpu);

  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Input {
    std::size_t predecessor = 0;
    bool queue = false;
    bool has_channel = false;
    std::uint64_t taken = 0;    // the newest run consumed so far
    std::uint64_t newest = 0;   // output that is there
    std::uint64_t waiting = 0;  // outputs in the queue
  };
  struct Output {
    std::size_t node = 0;
    std::size_t input = 0;
  };
  struct Node {
    NodeId id;
    const graph::Node* described = nullptr;
    std::optional<SubchainId> subchain;
    std::optional<std::size_t> next;     // in the subchain
    std::vector<std::size_t> followers;  // unscheduled
    Cpus::Thread thread = 0;             // its own; those that help follow
    Cpus::LevelNumber level = 0;         // its own thread's, but for those that wait for it
    int helpers = 0;
    std::vector<Input> inputs;
    std::vector<RunAccess::InputEdge> edges;  // by input
    std::vector<Output> outputs;
    Body body;
    Body effect;
    std::vector<std::unique_ptr<ChannelBase>> channels;  // by input
    std::optional<Nanos> period;                         // of its timer, if it has one
    TimePoint next_begin{};                              // by its timer
    std::optional<TimePoint> next_output;

    // Of one whose runs await input (graph::Graph::awaits_input()).
    bool awaits_input = false;
    std::vector<Ticks> clocks;  // of external nodes that feed it
    bool has_news = false;      // a predecessor has given something since its last run began
    bool waits_for_news = false;

    std::uint64_t word = 0;          // the newest trigger, or output of the node that it follows
    std::uint64_t token = 0;         // that of the newest run
    bool busy = false;               // woken, or at work
    int threads = 1;                 // that the run works on
    int working = 0;                 // of these, still at it
    Nanos share{0};                  // that each of them works
    Nanos wait{0};                   // of its first thread, still to come
    Nanos rest{0};                   // that it works afterwards
    std::vector<Nanos> used_before;  // by thread
    ctn::Run seen;                   // the run as its function sees it
    record::Run run;                 // reused
  };

  // Of an exclusive group.
  struct Exclusion {
    std::optional<std::size_t> holder;  // a node
    std::vector<std::size_t> waiting;   // who came first in front
  };

  Exclusion* exclusion_of(const Node& node);
  bool enter(Node& node);
  void leave(Node& node, int cpu);
  bool waits_for_exclusion(const Node& node);
  void set_level_of(Node& node, int helper, Cpus::LevelNumber level);
  void raise_holder(const Exclusion& exclusion);
  bool lacks_input(const Node& node) const;
  bool sleeps_for_input(Node& node);
  void begin_run(Node& node, int cpu);
  Nanos until_wait(Node& node);
  void consume(Node& node);
  void consume_newest(Node& node, std::size_t index);
  static bool is_stale(const Node& node);
  // What each of the run's threads works.
  Nanos share_of(Node& node, const model::RunDraw& draw, int cpu);
  void check_charge(const Node& node, const RunAccess::Charge& charge);
  void tell_mistake(const Node& node, std::string_view what, std::string hint);
  Nanos jitter_of(const record::Run& run) const;
  void end_run(Node& node, int cpu);
  bool output_due(Node& node);
  void publish(Node& node, int cpu);
  void tell_news(Node& consumer, int cpu);
  void pass_on(Node& node, bool emits, int cpu);
  void wake(Node& node, std::uint64_t token, int from_cpu);
  void give_output(const plan::Leader& leader, int from_cpu);
  void complete(SubchainId subchain, std::uint64_t token, int from_cpu);
  int threads_planned(const Node& node) const;
  Cpus::LevelNumber level_of(os::Level level) const { return real_time_ ? static_cast<Cpus::LevelNumber>(level) : 0; }

  const graph::App& app_;
  const policy::CpuKinds& kinds_;
  RunCosts& costs_;
  Cpus& cpus_;
  Cpus::Thread first_;
  Client& client_;
  Nanos overhead_;
  Nanos jitter_;
  bool real_time_;
  record::AgeTracker ages_;
  policy::BatchSizes batches_;
  bool follows_ages_;  // they are asked for
  std::vector<Node> nodes_;
  std::vector<Exclusion> exclusions_;  // as the app's exclusive groups
  std::vector<Signal> signals_;
  std::vector<Outputs> outputs_of_subchains_;
  std::vector<Outputs> outputs_of_nodes_;
  std::vector<Reservation> reservations_;  // by node; empty: none
  std::vector<std::size_t> node_of_;       // by thread, from `first`
  std::uint64_t dropped_ = 0;
};

template <class C>
C* Nodes::channel(NodeId from, NodeId to) {
  Node& node = nodes_[to.index()];
  for (std::size_t index = 0; index < node.inputs.size(); ++index) {
    if (node.inputs[index].predecessor != from.index() || nodes_[from.index()].described->external) continue;
    if (!node.channels[index]) node.channels[index] = std::make_unique<C>(static_cast<std::uint32_t>(index));
    use_channel(to, index, *node.channels[index]);
    return dynamic_cast<C*>(node.channels[index].get());
  }
  return nullptr;
}

}  // namespace ctn::sim
