#include "trial/machine.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/mixed.h"
#include "plan/limits.h"

namespace ctn::trial {
namespace {

std::size_t count_unscheduled(const graph::App& app) {
  const auto nodes = app.graph.nodes();
  return static_cast<std::size_t>(
      std::count_if(nodes.begin(), nodes.end(), [](const graph::Node& node) { return node.unscheduled; }));
}

bool any_awaits_input(const graph::Graph& graph) {
  const auto& order = graph.topological_order();
  return std::any_of(order.begin(), order.end(), [&](NodeId node) { return graph.awaits_input(node); });
}

std::size_t count_jobs(const graph::App& app, const Schedule& schedule) {
  std::size_t threads = 0;
  for (const Pipeline& pipeline : schedule.pipelines) {
    threads +=
        app.graph.subchain(pipeline.subchain).nodes.size() * static_cast<std::size_t>(std::max(pipeline.threads, 1));
  }
  return schedule.subchains.size() + count_unscheduled(app) + threads;
}

// A subchain that is triggered by the system's clock keeps no phase to one that is not ours: a trial goes once through
// all phases, as long as that is not much of a change.
Nanos sliding(Nanos period, Nanos horizon) {
  constexpr Nanos::rep kMinTicks = 50;
  const Nanos::rep ticks = horizon / period;
  return ticks < kMinTicks ? period : period - period / ticks;
}

// Of such calls `part` are true, evenly; `owed`: since the last that was.
bool falls_evenly(double& owed, double part) {
  constexpr double kRounding = 1e-9;
  owed += part;
  if (owed < 1.0 - kRounding) return false;
  owed -= 1.0;
  return true;
}

// By subchain. As a plan numbers them: the priorities of each core from 1, so what has one core is not above what has
// another, whatever the search had in mind. An unscheduled node goes where the lowest runs.
std::vector<Rank> ranks_as_planned(const Schedule& schedule) {
  const std::vector<Place>& places = schedule.subchains;
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return places[a].priority < places[b].priority; });
  std::vector<Rank> lower(static_cast<std::size_t>(schedule.cores), Rank{0});
  std::vector<Rank> ranks(places.size(), static_cast<Rank>(dispatch::MemberLevel::kOrdinary));
  for (const std::size_t index : order) {
    const Place& place = places[index];
    if (place.form == Form::kPriority) ranks[index] = ++lower[static_cast<std::size_t>(place.core)];
  }
  return ranks;
}

std::vector<Ticks> clocks_of(const graph::App& app, const Options& options) {
  std::vector<Ticks> clocks = options.clocks;
  clocks.resize(app.graph.nodes().size());
  for (std::size_t index = 0; index < clocks.size(); ++index) {
    const graph::Node& node = app.graph.nodes()[index];
    if (!node.has_clock() || clocks[index].period > Nanos{0}) continue;
    clocks[index] = {TimePoint{}, sliding(*node.period, options.horizon)};
  }
  return clocks;
}

}  // namespace

Machine::Machine(const graph::App& app, const Samples& samples, const ChainPrefixes& prefixes, const Schedule& schedule,
                 const Options& options)
    : app_(app),
      samples_(samples),
      schedule_(schedule),
      options_(options),
      warm_from_(TimePoint{} + options.warm_up),
      clocks_(clocks_of(app, options)),
      nodes_(app.graph.nodes().size()),
      news_(nodes_.size()),
      idlers_(nodes_.size()),
      inputs_(nodes_.size()),
      exclusions_(app.exclusive.size()),
      unscheduled_of_node_(nodes_.size()),
      timers_(2 * static_cast<std::size_t>(schedule.cores) + schedule.subchains.size() + count_unscheduled(app) +
              (samples.any_waits() || any_awaits_input(app.graph) ? count_jobs(app, schedule) : 0)),
      cores_(static_cast<std::size_t>(schedule.cores), count_jobs(app, schedule), options.overheads.context_switch,
             timers_),
      lineage_(app, prefixes, clocks_, warm_from_, options.before_ticks, options.p95) {
  if (options.observer != nullptr) log_.emplace(app, *options.observer);
  for (int core = 0; core < schedule.cores; ++core) kind_of_core_.push_back(app.kind_of(core));
  add_nodes();
  add_subchains();
  add_pipelines();
}

void Machine::add_nodes() {
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    const graph::Node& described = app_.graph.nodes()[index];
    nodes_[index].runs = options_.first_draw;
    nodes_[index].output_period = described.output_period.value_or(Nanos{0});
    nodes_[index].outputs_per_run = 1.0 / samples_.runs_per_output(NodeId(index));
    nodes_[index].outputs_owed = 1.0 - nodes_[index].outputs_per_run;
    if (samples_.has_batches(NodeId(index))) add_queues(NodeId(index));
    if (samples_.idle(NodeId(index)).part > 0.0) idlers_[index].emplace().idle = samples_.idle(NodeId(index));
    if (app_.graph.awaits_input(NodeId(index))) inputs_[index].emplace();
    if (idlers_[index] || inputs_[index]) add_news(NodeId(index));
    if (!described.unscheduled) continue;
    unscheduled_of_node_[index] = unscheduled_.size();
    unscheduled_.push_back({.node = NodeId(index),
                            .period = described.follows ? std::nullopt : std::optional(clocks_[index].period),
                            .followers = {},
                            .led = {}});
  }
  for (std::size_t index = 0; index < unscheduled_.size(); ++index) {
    const std::optional<NodeId> follows = app_.graph.node(unscheduled_[index].node).follows;
    if (follows) unscheduled_[*unscheduled_of_node_[follows->index()]].followers.push_back(index);
  }
}

void Machine::add_queues(NodeId id) {
  for (const NodeId from : app_.graph.node(id).predecessors) {
    nodes_[id.index()].queues.push_back(queues_.size());
    nodes_[from.index()].feeds.push_back(queues_.size());
    queues_.push_back(0);
  }
}

void Machine::add_news(NodeId id) {
  News& news = news_[id.index()].emplace();
  for (const NodeId from : app_.graph.node(id).predecessors) {
    if (app_.graph.node(from).is_external_clock()) news.add_clock(from);
    nodes_[from.index()].tells.push_back(id.index());
  }
}

void Machine::add_subchains() {
  const std::vector<Rank> ranks = ranks_as_planned(schedule_);
  for (std::size_t index = 0; index < schedule_.subchains.size(); ++index) {
    const Place& place = schedule_.subchains[index];
    Subchain& subchain = subchains_.emplace_back();
    subchain.id = SubchainId(index);
    subchain.nodes = app_.graph.subchain(subchain.id).nodes;
    subchain.place = &place;
    subchain.rank = ranks[index];
  }
  for (std::size_t index = 0; index < subchains_.size(); ++index) {
    const std::optional<plan::After>& after = schedule_.subchains[index].after;
    if (!after) continue;
    const NodeId* const node = after->node();
    std::vector<std::size_t>& followers = node != nullptr ? unscheduled_[*unscheduled_of_node_[node->index()]].led
                                                          : subchains_[after->subchain()->index()].followers;
    followers.push_back(index);
  }
}

// --- Time ---

Figures Machine::run() {
  start();
  run_until(warm_from_);
  for (int core = 0; core < cores_.count(); ++core) cores_.take_busy(core, now_);
  const TimePoint end = warm_from_ + options_.horizon;
  run_until(end);
  return figures(end);
}

void Machine::start() {
  for (std::size_t index = 0; index < subchains_.size(); ++index) {
    if (subchains_[index].place->form == Form::kPriority) start_pacing(index);
  }
  for (std::size_t index = 0; index < unscheduled_.size(); ++index) {
    Unscheduled& node = unscheduled_[index];
    if (!node.period) continue;
    node.next_begin = clocks_[node.node.index()].next(TimePoint{} + Nanos{1});
    set_timer(source_of_unscheduled(index), node.next_begin, node.timers_set);
  }
  start_frames();
  for (const Pipe& pipe : pipes_) pace(subchains_[pipe.subchain], WokenBy::kEvent);
  settle();
}

void Machine::run_until(TimePoint end) {
  while (timers_.next() <= end) {
    now_ = std::max(now_, timers_.next());
    ++events_;
    carry_out(timers_.next_source());
    settle();
  }
  now_ = end;
}

void Machine::carry_out(Timers::Source source) {
  if (source < source_of_subchain(0)) return core_event(static_cast<int>(source));
  timers_.set(source, kNever);
  if (source < source_of_unscheduled(0)) return pace(subchains_[source - source_of_subchain(0)], WokenBy::kTimer);
  if (source < source_of_frames(0)) return unscheduled_due(source - source_of_unscheduled(0));
  if (source >= source_of_wait(0)) return wait_over(source - source_of_wait(0));
  step_frames(static_cast<int>(source - source_of_frames(0)), WokenBy::kTimer);
}

// A thread that sleeps until `due` can run a little later: by how much is chance, the same in every trial.
void Machine::set_timer(Timers::Source source, TimePoint due, std::uint32_t& timers_set) {
  const Overheads& costs = options_.overheads;
  Nanos latency = costs.timer_latency;
  if (costs.timer_jitter > Nanos{0}) {
    const std::uint64_t key = (std::uint64_t{source} << 32U) + options_.first_draw + ++timers_set;
    latency += Nanos{static_cast<Nanos::rep>(mixed(key * kGolden) >> 48U) * costs.timer_jitter.count() >> 16};
  }
  timers_.set(source, std::max(due, now_) + latency);
}

// A core that is named twice is settled twice, which changes nothing.
void Machine::touch(int core) {
  if (touched_.empty() || touched_.back() != core) touched_.push_back(core);
}

void Machine::settle() {
  while (!touched_.empty()) {
    const int core = touched_.back();
    touched_.pop_back();
    if (!pipes_.empty()) take_waiting(core);
    const Job job = cores_.settle(core, now_);
    if (job == kNoJob) continue;
    const bool lacks = lacks_input(job);
    if (!lacks && enter(job)) {
      cores_.begin(core, begin_job(job, core));
      continue;
    }
    cores_.pause(core);
    touch(core);
    if (lacks) await_input(job);
  }
}

// A controller looks, acts, and sleeps again.
void Machine::hold(int core, WokenBy by) {
  const Overheads& costs = options_.overheads;
  cores_.hold(core, now_, costs.context_switch + (by == WokenBy::kTimer ? costs.dispatch_timer : costs.dispatch_event));
}

// --- Runs ---

// Whose run the job is in.
NodeId Machine::node_of(Job job) const {
  if (job < subchains_.size()) return subchains_[job].nodes[subchains_[job].position];
  if (job < first_pipe_thread()) return unscheduled_[job - job_of_unscheduled(0)].node;
  const PipeThread& thread = pipe_threads_[job - first_pipe_thread()];
  return pipes_[thread.pipe].stages[thread.stage].node;
}

Nanos Machine::begin_job(Job job, int core) {
  if (job >= first_pipe_thread()) return begin_pipe_thread(pipe_threads_[job - first_pipe_thread()], core);
  const NodeId node = node_of(job);
  if (nodes_[node.index()].rest > Nanos{0}) return rest_of_run(node);
  return until_wait(node, begin_run(node, core));
}

Nanos Machine::begin_run(NodeId id, int core) {
  Node& node = nodes_[id.index()];
  lineage_.begin(id, now_);
  if (log_) log_->begin(id, now_);
  std::optional<News>& news = news_[id.index()];
  const bool is_new = news && news->any(now_, clocks_);
  if (news) news->begin_run(now_);
  if (idlers_[id.index()] && begin_idle(*idlers_[id.index()], is_new)) {
    return to_nanos(idlers_[id.index()]->idle.cost) + options_.overheads.run + options_.overheads.context_switch;
  }
  node.wait = samples_.wait(id, node.runs);
  const std::size_t kind = kind_of_core_[static_cast<std::size_t>(core)];
  const Nanos cpu = samples_.draw(id, kind, node.runs++) + samples_.of_items(id, kind, take_batch(node));
  return cpu + options_.overheads.run + options_.overheads.context_switch;
}

// Whether the run that begins is idle. Of those that find nothing new, so many are, evenly.
bool Machine::begin_idle(Idler& idler, bool is_new) {
  idler.is_new = is_new;
  idler.is_idle = !is_new && falls_evenly(idler.owed, idler.idle.part);
  return idler.is_idle;
}

// How many items there are.
std::size_t Machine::take_batch(Node& node) {
  std::size_t items = 0;
  for (const std::size_t queue : node.queues) items += std::exchange(queues_[queue], std::size_t{0});
  return items;
}

// What of a run's `work` comes first; the rest comes after its wait.
Nanos Machine::until_wait(NodeId id, Nanos work) {
  Node& node = nodes_[id.index()];
  if (node.wait == Nanos{0}) return work;
  node.rest = std::max(work / 2, Nanos{1});
  return work - node.rest;
}

Nanos Machine::rest_of_run(NodeId id) {
  return std::exchange(nodes_[id.index()].rest, Nanos{0}) + options_.overheads.context_switch;
}

// Whether the job's run is to wait before it goes on. Threads that help do not.
bool Machine::waits(Job job) const {
  const bool helps = job >= first_pipe_thread() && pipe_threads_[job - first_pipe_thread()].helper;
  return !helps && nodes_[node_of(job).index()].wait > Nanos{0};
}

// The job on the core has come to its run's wait.
void Machine::wait(Job job, int core) {
  Node& node = nodes_[node_of(job).index()];
  // Threads of a pipeline go on where there is a core for them.
  job < first_pipe_thread() ? cores_.pause(core) : cores_.end_work(core);
  set_timer(source_of_wait(job), now_ + std::exchange(node.wait, Nanos{0}), node.timers_set);
}

void Machine::wait_over(Job job) {
  if (std::optional<Input>& input = inputs_[node_of(job).index()]) input->waiting.reset();
  if (job >= first_pipe_thread()) return queue_for_core(pipes_[pipe_threads_[job - first_pipe_thread()].pipe], job);
  cores_.resume(job);
  touch(cores_.core_of(job));
}

// Whether it emits.
bool Machine::end_run(NodeId id) {
  leave(id);
  const bool emitted = emits(id);
  lineage_.end(id, now_, emitted);
  if (log_) log_->end(id, now_, emitted);
  if (!emitted) return false;
  for (const std::size_t told : nodes_[id.index()].tells) {
    news_[told]->came();
    input_came(NodeId(told));
  }
  for (const std::size_t queue : nodes_[id.index()].feeds)
    queues_[queue] = std::min(queues_[queue] + 1, kQueueCapacity);
  return true;
}

// Of runs that find nothing new, those that are not idle are those that gave an output.
bool Machine::emits(NodeId id) {
  Node& node = nodes_[id.index()];
  const std::optional<Idler>& idler = idlers_[id.index()];
  if (idler && idler->is_idle) return false;
  if (idler && !idler->is_new && node.output_period == Nanos{0}) return true;
  return output_due(node);
}

// At its first run, and then on average once a period, as long as it runs at least that often; or evenly, as many of
// its runs as were measured.
bool Machine::output_due(Node& node) const {
  if (node.output_period == Nanos{0}) return falls_evenly(node.outputs_owed, node.outputs_per_run);
  if (node.next_output && now_ < *node.next_output) return false;
  node.next_output = std::max(node.next_output.value_or(now_) + node.output_period, now_);
  return true;
}

void Machine::core_event(int core) {
  touch(core);
  const Cores::Event event = cores_.account_event(core, now_);
  if (event == Cores::Event::kFree) return;
  const Job job = cores_.current(core);
  if (waits(job)) return wait(job, core);
  if (job < subchains_.size()) return subchain_node_ended(job, core);
  if (job < first_pipe_thread()) return unscheduled_ended(job - job_of_unscheduled(0), core);
  pipe_thread_ended(pipe_threads_[job - first_pipe_thread()], core);
}

void Machine::subchain_node_ended(std::size_t index, int core) {
  Subchain& subchain = subchains_[index];
  const bool emits = end_run(subchain.nodes[subchain.position]);
  if (emits && subchain.position + 1 < subchain.nodes.size()) {
    ++subchain.position;
    return cores_.continue_work(static_cast<Job>(index));
  }
  cores_.end_work(core);
  subchain_run_over(subchain, emits);
}

void Machine::subchain_run_over(Subchain& subchain, bool emitted) {
  count_run(subchain);
  ++subchain.completed;
  if (emitted) hear_output(subchain.followers);
  if (subchain.trigger) {
    if (subchain.awaits_completion) pace(subchain, WokenBy::kEvent);
  } else if (frames_[static_cast<std::size_t>(subchain.place->core)]->awaited == subchain.id) {
    step_frames(subchain.place->core, WokenBy::kEvent);
  }
}

void Machine::count_run(Subchain& subchain) {
  if (now_ < warm_from_) return;
  if (subchain.runs++ == 0) subchain.first_end = now_;
  subchain.last_end = now_;
}

// --- Unscheduled nodes ---

void Machine::unscheduled_due(std::size_t index) {
  Unscheduled& node = unscheduled_[index];
  const Job job = job_of_unscheduled(index);
  if (cores_.has_work(job)) {
    node.owed = true;
    return;
  }
  node.core = core_for_unscheduled(node.core);
  cores_.add_work(job, node.core, kAboveAll);
  touch(node.core);
}

void Machine::unscheduled_ended(std::size_t index, int core) {
  Unscheduled& node = unscheduled_[index];
  cores_.end_work(core);
  if (end_run(node.node)) {
    for (const std::size_t follower : node.followers) unscheduled_due(follower);
    hear_output(node.led);
  }
  if (node.period) {
    node.next_begin = std::max(node.next_begin + *node.period, now_);
    set_timer(source_of_unscheduled(index), node.next_begin, node.timers_set);
  } else if (std::exchange(node.owed, false)) {
    unscheduled_due(index);
  }
}

// An idle one, else where the lowest has the core; where it ran last rather than elsewhere.
int Machine::core_for_unscheduled(int last) const {
  int best = last;
  for (int core = 0; core < cores_.count() && !cores_.idle(best); ++core) {
    if (cores_.rank_on(core) < cores_.rank_on(best)) best = core;
  }
  return best;
}

// --- What it came to ---

TermFigures Machine::figures_of(TermSamples& samples) const {
  TermFigures figures{.count = samples.count};
  if (samples.count > 0) figures.mean_ms = samples.sum / static_cast<double>(samples.count) / 1e6;
  if (samples.count < kMinSamples) figures.mean_ms = std::max(figures.mean_ms, to_millis(options_.horizon).count());
  if (options_.p95 && samples.count > 0) {
    // By nearest rank, as base/statistics.h.
    const double rank = std::ceil(0.95 * static_cast<double>(samples.count) - 1e-9);
    const auto place = samples.values.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
    std::nth_element(samples.values.begin(), place, samples.values.end());
    figures.p95_ms = *place / 1e6;
  }
  return figures;
}

Figures Machine::figures(TimePoint end) {
  Figures figures;
  figures.events = events_;
  for (std::size_t term = 0; term < app_.objective.size(); ++term) {
    figures.terms.push_back(figures_of(lineage_.terms()[term]));
    figures.objective += app_.objective[term].weight * figures.terms.back().mean_ms;
    figures.enough = figures.enough && figures.terms.back().count >= kMinSamples;
  }
  for (int core = 0; core < cores_.count(); ++core) {
    figures.busy.push_back(static_cast<double>(cores_.take_busy(core, end).count()) /
                           static_cast<double>(options_.horizon.count()));
  }
  for (const Subchain& subchain : subchains_) {
    SubchainFigures& of = figures.subchains.emplace_back();
    of.runs = subchain.runs;
    if (subchain.runs < 2) continue;
    of.period_ms = to_millis(subchain.last_end - subchain.first_end).count() / static_cast<double>(subchain.runs - 1);
  }
  return figures;
}

}  // namespace ctn::trial
