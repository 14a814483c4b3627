// One trial: a schedule in virtual time (trial.h). What competes for cores (cores.h), as numbered there:
//   each subchain on one core        whichever node of it is to run
//   each unscheduled node
//   each thread of a pipeline's node
//
// A run of a queue node takes what waits when it begins, and costs what that adds; queues of nodes to which that makes
// no difference are not counted.
//
// A node may be known to do something else where it finds nothing new: such runs are idle, then.
//
// A run waits in its middle: its job is away until a timer ends the wait, and then begins the rest of the run.
//
// A run of a node that needs input and is triggered without waits, away from its core, until a predecessor emits or a
// clock of one ticks. It holds no exclusive group meanwhile.
//
// A run of a node in an exclusive group holds that group; another of it waits away from its core, and raises the
// holder to its own rank. When the run ends, the highest of those that wait gets its core back and asks again.
// Pipelines do not know of exclusive groups.
//
// Runs and unscheduled nodes are in machine.cpp, runs that await input in machine_inputs.cpp, exclusive groups in
// machine_exclusions.cpp, triggers of subchains that do not take turns in machine_triggers.cpp, cores of frames in
// machine_frames.cpp, pipelines in machine_pipelines.cpp.
//
// Units: in the types. Thread safety: none; one owner; used once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "dispatch/subchain_trigger.h"
#include "graph/app.h"
#include "trial/cores.h"
#include "trial/lineage.h"
#include "trial/news.h"
#include "trial/run_log.h"
#include "trial/samples.h"
#include "trial/schedule.h"
#include "trial/timers.h"
#include "trial/trial.h"

namespace ctn::trial {

class Machine {
 public:
  // All outlive it.
  Machine(const graph::App& app, const Samples& samples, const ChainPrefixes& prefixes, const Schedule& schedule,
          const Options& options);

  // From the start to the end of the horizon.
  Figures run();

 private:
  enum class WokenBy { kTimer, kEvent };

  struct Node {
    std::uint32_t runs = 0;  // begun, from the first draw on
    // Of the run under way.
    Nanos wait{0};  // that is still to come
    Nanos rest{0};  // CPU time after it
    std::uint32_t timers_set = 0;
    Nanos output_period{0};  // 0: none
    std::optional<TimePoint> next_output;
    double outputs_per_run = 1.0;     // where it has no output period
    double outputs_owed = 0.0;        // of these, by the runs since the last one
    std::vector<std::size_t> queues;  // that it takes batches from, where they cost something
    std::vector<std::size_t> feeds;   // such queues that its outputs go to
    std::vector<std::size_t> tells;   // nodes of which it is kept whether there is news
  };
  // Of a node whose runs await input (graph::Graph::awaits_input()).
  struct Input {
    std::optional<Job> waiting;  // its run, triggered without
  };
  // Of a node that does something else where it finds nothing new.
  struct Idler {
    model::IdleRuns idle;
    double owed = 0.0;  // idle runs, by those that found nothing new since the last one
    // Of the run under way.
    bool is_idle = false;
    bool is_new = true;
  };
  struct Subchain {
    SubchainId id;
    std::span<const NodeId> nodes;
    const Place* place = nullptr;
    std::vector<std::size_t> followers;  // subchains that its outputs trigger
    std::size_t position = 0;            // of the node that runs or is to run
    Rank rank = 0;
    std::optional<dispatch::SubchainTrigger> trigger;  // none: it takes turns
    bool awaits_completion = false;                    // its controller is to be woken at the end of a run
    std::uint64_t leader_outputs = 0;
    std::uint64_t completed = 0;  // the newest trigger whose run has ended
    std::uint32_t timers_set = 0;
    // Of the horizon.
    std::size_t runs = 0;
    TimePoint first_end{};
    TimePoint last_end{};
  };
  struct Exclusion {
    std::optional<Job> holder;
    Rank own = 0;              // the holder's, but for those that wait
    std::vector<Job> waiting;  // who came first in front
  };
  struct Unscheduled {
    NodeId node;
    std::optional<Nanos> period;
    std::vector<std::size_t> followers;  // other unscheduled nodes
    std::vector<std::size_t> led;        // subchains that its outputs trigger
    TimePoint next_begin{};
    int core = 0;       // where it ran last
    bool owed = false;  // another run, after the one under way
    std::uint32_t timers_set = 0;
  };
  struct Frames {
    dispatch::SharedCoreDispatcher dispatcher;
    std::vector<std::uint64_t> progress;  // by slot
    std::optional<SubchainId> awaited;    // the end of whose run the dispatcher waits for
    std::uint32_t timers_set = 0;
  };
  struct Stage {  // a node of a pipeline
    NodeId node;
    Job first_thread = 0;
    std::uint64_t word = 0;   // the newest trigger that it was given
    std::uint64_t token = 0;  // that of its newest run
    bool busy = false;
    int working = 0;  // threads of the run under way
    Nanos share{0};   // that each of them works
  };
  struct Pipe {
    std::size_t subchain = 0;
    const Pipeline* pipeline = nullptr;
    std::vector<Stage> stages;
    std::deque<Job> waiting;  // for one of the cores
  };
  struct PipeThread {
    std::size_t pipe = 0;
    std::size_t stage = 0;
    bool helper = false;
  };

  // --- Sources of events ---
  Timers::Source source_of_subchain(std::size_t index) const {
    return static_cast<Timers::Source>(schedule_.cores) + static_cast<Timers::Source>(index);
  }
  Timers::Source source_of_unscheduled(std::size_t index) const {
    return source_of_subchain(subchains_.size() + index);
  }
  Timers::Source source_of_frames(int core) const {
    return source_of_unscheduled(unscheduled_.size()) + static_cast<Timers::Source>(core);
  }
  Timers::Source source_of_wait(Job job) const { return source_of_frames(schedule_.cores) + job; }
  Job job_of_unscheduled(std::size_t index) const { return static_cast<Job>(subchains_.size() + index); }
  Job first_pipe_thread() const { return static_cast<Job>(subchains_.size() + unscheduled_.size()); }

  void add_nodes();
  void add_queues(NodeId node);
  void add_news(NodeId node);
  void add_subchains();
  void add_pipelines();
  void start();
  void run_until(TimePoint end);
  void carry_out(Timers::Source source);
  void set_timer(Timers::Source source, TimePoint due, std::uint32_t& timers_set);
  void touch(int core);
  void settle();
  void hold(int core, WokenBy by);

  // --- Runs ---
  NodeId node_of(Job job) const;
  Nanos begin_job(Job job, int core);
  Nanos begin_run(NodeId node, int core);
  std::size_t take_batch(Node& node);
  static bool begin_idle(Idler& idler, bool is_new);
  bool emits(NodeId node);
  Nanos until_wait(NodeId node, Nanos work);
  Nanos rest_of_run(NodeId node);
  bool waits(Job job) const;
  void wait(Job job, int core);
  void wait_over(Job job);
  bool end_run(NodeId node);
  bool output_due(Node& node) const;
  void core_event(int core);
  void subchain_node_ended(std::size_t index, int core);
  void subchain_run_over(Subchain& subchain, bool emitted);
  void count_run(Subchain& subchain);

  // --- Runs that await input ---
  bool lacks_input(NodeId node) const;
  bool lacks_input(Job job) const;
  void await_input(Job job);
  void input_came(NodeId node);

  // --- Exclusive groups ---
  Exclusion* exclusion_of(Job job);
  bool enter(Job job);
  void leave(NodeId node);
  void set_rank(Job job, Rank rank);
  void raise_holder(const Exclusion& exclusion);

  // --- Triggers ---
  bool under_way(const Subchain& subchain) const { return cores_.has_work(static_cast<Job>(subchain.id.index())); }
  dispatch::Pacing pacing_of(const Place& place) const;
  void start_pacing(std::size_t index);
  void pace(Subchain& subchain, WokenBy by);
  void begin_first_node(Subchain& subchain);
  int core_of_controller(const Subchain& subchain) const;
  void hear_output(const std::vector<std::size_t>& followers);

  // --- Unscheduled nodes ---
  void unscheduled_due(std::size_t index);
  void unscheduled_ended(std::size_t index, int core);
  int core_for_unscheduled(int last) const;

  // --- Cores of frames ---
  static Rank rank_of(dispatch::MemberLevel level) { return static_cast<Rank>(level); }
  void start_frames();
  void step_frames(int core, WokenBy by);

  // --- Pipelines ---
  void wake(Pipe& pipe, std::size_t stage, std::uint64_t token);
  void queue_run(Pipe& pipe, const Stage& stage);
  void queue_for_core(Pipe& pipe, Job job);
  void take_waiting(int core);
  Nanos begin_pipe_thread(const PipeThread& thread, int core);
  void pipe_thread_ended(const PipeThread& thread, int core);

  Figures figures(TimePoint end);
  TermFigures figures_of(TermSamples& samples) const;

  const graph::App& app_;
  const Samples& samples_;
  const Schedule& schedule_;
  const Options& options_;
  TimePoint now_{};
  TimePoint warm_from_;
  std::vector<Ticks> clocks_;  // by NodeId
  std::vector<Node> nodes_;
  std::vector<std::optional<News>> news_;     // by NodeId; of idlers, and of nodes whose runs await input
  std::vector<std::optional<Idler>> idlers_;  // by NodeId
  std::vector<std::optional<Input>> inputs_;  // by NodeId
  std::vector<std::size_t> queues_;           // outputs that wait in each
  std::vector<Exclusion> exclusions_;         // as the app's exclusive groups
  std::vector<Subchain> subchains_;
  std::vector<Unscheduled> unscheduled_;
  std::vector<std::optional<std::size_t>> unscheduled_of_node_;
  std::vector<std::optional<Frames>> frames_;  // by core; empty where there are none at all
  std::vector<Pipe> pipes_;
  std::vector<PipeThread> pipe_threads_;
  std::vector<std::optional<std::size_t>> pipe_of_core_;
  std::vector<std::optional<std::size_t>> pipe_of_subchain_;
  std::vector<std::size_t> kind_of_core_;
  Timers timers_;
  Cores cores_;
  Lineage lineage_;
  std::optional<RunLog> log_;
  std::vector<int> touched_;  // cores on which another subchain may have to run
  std::uint64_t events_ = 0;
};

}  // namespace ctn::trial
