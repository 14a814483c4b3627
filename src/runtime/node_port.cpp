#include "runtime/node_port.h"

#include <algorithm>
#include <utility>

#include "record/input_edges.h"
#include "runtime/report.h"

namespace ctn::runtime {
namespace {

std::uint32_t low(std::uint64_t token) { return static_cast<std::uint32_t>(token); }

// The token of which a word has the low half: the newest one that ended is not far from it.
std::uint64_t token_near(std::uint64_t completed, std::uint32_t word) {
  const auto ahead = static_cast<std::int32_t>(word - low(completed));
  return completed + static_cast<std::uint64_t>(static_cast<std::int64_t>(ahead));
}

void complete(os::Threads& threads, const Region& region, SignalCell& signal, std::uint64_t token) {
  std::uint64_t before = signal.completed.load(std::memory_order_relaxed);
  while (before < token && !signal.completed.compare_exchange_weak(before, token, std::memory_order_seq_cst)) {
  }
  // Sequentially consistent on both sides: either this thread sees that the controller wants to be woken, or the
  // controller sees the completion before it sleeps.
  if (signal.wants_completions.load(std::memory_order_seq_cst) == 0) return;
  const std::uint32_t holder = signal.holder.load(std::memory_order_seq_cst);
  if (holder != 0 && holder <= region.controller_cells()) region.controller_cell(holder - 1).wake(threads);
}

bool is_source(const graph::Graph& graph, NodeId node) {
  const std::vector<NodeId>& inputs = graph.node(node).predecessors;
  return std::all_of(inputs.begin(), inputs.end(), [&](NodeId input) { return graph.node(input).external; });
}

}  // namespace

NodePort::Binding::Binding(const graph::Graph& graph, NodeId node, const Region& in, std::uint64_t made)
    : number(made), region(&in), own(&in.node(node)), reports(in.reports_writer(node)) {
  for (const NodeId predecessor : graph.node(node).predecessors) {
    predecessors.push_back(graph.node(predecessor).external ? nullptr : &in.node(predecessor));
  }
  for (const NodeId successor : graph.node(node).successors) {
    if (graph.node(successor).follows == node) followers.push_back(&in.node(successor));
  }
  if (!graph.node(node).subchain) return;
  const SubchainId subchain = *graph.node(node).subchain;
  const std::vector<NodeId>& nodes = graph.subchain(subchain).nodes;
  const auto after = std::find(nodes.begin(), nodes.end(), node) + 1;
  if (after != nodes.end()) next = &in.node(*after);
  signal = &in.signal(subchain);
}

// --- Any thread ---

NodePort::NodePort(os::Os& os, const graph::Graph& graph, NodeId node, const Region& region)
    : os_(os), node_(node), runs_(os, graph, node, shared_) {
  add_binding(region, graph);
  runs_.follow_move();
}

void NodePort::move_to(const Region& region, const graph::Graph& graph) {
  add_binding(region, graph);
  wake_if_moved();
}

void NodePort::wake_if_moved() const {
  const Binding* const old = in_use();
  if (old == nullptr || old == &newest()) return;
  // Any change of the word wakes the node; it looks at its binding first.
  old->own->word.fetch_add(1, std::memory_order_release);
  os_.wake(old->own->word);
}

// Null: the node is about to go by the newest.
const NodePort::Binding* NodePort::in_use() const {
  const Binding* const named = shared_.in_use.load(std::memory_order_seq_cst);
  const auto is_named = [&](const auto& binding) { return binding.get() == named; };
  return std::any_of(bindings_.begin(), bindings_.end(), is_named) ? named : nullptr;
}

void NodePort::add_binding(const Region& region, const graph::Graph& graph) {
  const Binding* const before = shared_.newest.load(std::memory_order_relaxed);
  const Binding* const in_use = shared_.in_use.load(std::memory_order_seq_cst);
  std::erase_if(bindings_, [&](const auto& binding) { return binding.get() != before && binding.get() != in_use; });
  bindings_.push_back(std::make_unique<const Binding>(graph, node_, region, ++made_));
  shared_.newest.store(bindings_.back().get(), std::memory_order_seq_cst);
}

// In the old region, the node may belong to another process, which must not be woken.
void NodePort::bind_to(const Region& region, const graph::Graph& graph) {
  add_binding(region, graph);
  shared_.in_use.store(&newest(), std::memory_order_release);
}

bool NodePort::uses(const Region& region) const {
  const Binding* const old = in_use();
  return newest().region == &region || (old != nullptr && old->region == &region);
}

// A server that goes on just now may trigger it, too: then its token stands.
bool NodePort::trigger_locally() {
  const Binding& binding = newest();
  const std::uint64_t completed = binding.signal->completed.load(std::memory_order_acquire);
  std::uint32_t word = binding.own->word.load(std::memory_order_acquire);
  if (token_near(completed, word) > completed) {
    // A server that is stopped, or killed, between a trigger and its wake leaves the node asleep.
    os_.wake(binding.own->word);
    return false;
  }
  if (!binding.own->word.compare_exchange_strong(word, low(completed + 1), std::memory_order_acq_rel)) return false;
  os_.wake(binding.own->word);
  return true;
}

void NodePort::abandon_run() {
  const Binding& binding = newest();
  const std::uint64_t completed = binding.signal->completed.load();
  binding.signal->completed.store(token_near(completed, binding.own->word.load(std::memory_order_acquire)),
                                  std::memory_order_release);
}

// Others may write the word for no reason.
bool NodePort::wait_until(TimePoint due) {
  while (!stopping() && os_.now() < due) {
    const NodeCell& own = *newest().own;
    const std::uint32_t word = own.word.load(std::memory_order_acquire);
    if (!stopping()) os_.wait(own.word, word, due);
  }
  return !stopping();
}

void NodePort::stop() {
  shared_.stopping.store(true, std::memory_order_release);
  // It may not have noticed yet that it was moved.
  wake_if_moved();
  // Any change of the word wakes the node; it looks at the flag first.
  NodeCell& own = *newest().own;
  own.word.fetch_add(1, std::memory_order_release);
  os_.wake(own.word);
}

// --- The node's own thread ---

NodePort::Runs::Runs(os::Os& os, const graph::Graph& graph, NodeId node, Shared& shared)
    : os_(os),
      id_(node),
      node_(graph.node(node)),
      is_source_(is_source(graph, node)),
      paces_itself_(node_.unscheduled && !node_.follows),
      shared_(shared),
      edges_(record::input_edges(graph, node)),
      words_(report_words(edges_.size())),
      taken_(edges_.size(), 0),
      origins_(edges_.size(), RunAccess::kNoOrigin),
      wait_(os) {}

void NodePort::Runs::follow_move() {
  const Binding* newest = shared_.newest.load(std::memory_order_seq_cst);
  for (const Binding* named = shared_.in_use.load(std::memory_order_relaxed); named != newest;) {
    named = newest;
    shared_.in_use.store(named, std::memory_order_seq_cst);
    newest = shared_.newest.load(std::memory_order_seq_cst);
  }
  if (newest->number != bound_) bind(*newest);
}

void NodePort::Runs::bind(const Binding& binding) {
  const bool moves = binding_ != nullptr;
  binding_ = &binding;
  bound_ = binding.number;
  std::fill(taken_.begin(), taken_.end(), 0);
  number_ = std::max(number_, binding.own->number.load(std::memory_order_acquire));
  if (node_.follows) {
    // Outputs given before the node was there are past; outputs given in the region that it moves to wait for it.
    token_ = moves ? 0 : binding.own->word.load(std::memory_order_acquire);
  } else {
    // A node that comes to a subchain which has run before goes by its newest token. A trigger that waits already is
    // taken; one that is past is not.
    const std::uint64_t completed = binding.signal != nullptr ? binding.signal->completed.load() : 0;
    token_ = std::min(token_near(completed, binding.own->word.load(std::memory_order_acquire)), completed);
  }
}

std::optional<std::uint32_t> NodePort::Runs::word_unless_stopped() {
  const auto stopping = [this] { return shared_.stopping.load(std::memory_order_acquire); };
  for (;;) {
    follow_move();
    if (stopping()) {
      // Restores the word that stop() changed, since the next program that runs this node goes by it.
      binding_->own->word.store(low(token_), std::memory_order_release);
      return std::nullopt;
    }
    const std::uint32_t word = binding_->own->word.load(std::memory_order_acquire);
    // After the word, which the thread that stops or moves the node changes last: it may have done so before bind()
    // read it.
    if (!stopping() && shared_.newest.load(std::memory_order_acquire) == binding_) return word;
  }
}

// To be read after the word: whoever triggers the subchain when it is complete has said so before.
bool NodePort::Runs::is_let_go() const {
  return binding_->signal != nullptr && binding_->signal->incomplete.load(std::memory_order_acquire) != 0;
}

// The low half tells the difference, which may be negative: a scheduler that was stopped while its nodes paced
// themselves goes on with the tokens that it had.
void NodePort::Runs::go_by(std::uint32_t word) {
  token_ += static_cast<std::uint64_t>(static_cast<std::int64_t>(static_cast<std::int32_t>(word - low(token_))));
}

Awaited NodePort::Runs::await(bool asks) {
  if (paces_itself_) return shared_.stopping.load(std::memory_order_acquire) ? Awaited::kStopped : Awaited::kTrigger;
  if (!own_cpu_ || os_.now() - end_ > kStraightBack) own_cpu_ = os_.thread_cpu_time();
  while (const std::optional<std::uint32_t> word = word_unless_stopped()) {
    if (asks && is_let_go()) {
      go_by(*word);
      return Awaited::kIncomplete;
    }
    if (*word == low(token_)) {
      if (asks) {
        os_.wait_for_wake(binding_->own->word, *word);
      } else {
        os_.wait(binding_->own->word, *word, kNever);
      }
      continue;
    }
    go_by(*word);
    has_waited_ = true;
    return Awaited::kTrigger;
  }
  return Awaited::kStopped;
}

bool NodePort::Runs::await_complete() {
  while (const std::optional<std::uint32_t> word = word_unless_stopped()) {
    if (!is_let_go()) return true;
    go_by(*word);
    os_.wait_for_wake(binding_->own->word, *word);
  }
  return false;
}

void NodePort::Runs::begin(Run& run) {
  if (!has_waited_) {
    follow_move();
    number_ = std::max(number_, binding_->own->number.load(std::memory_order_acquire));
  }
  RunAccess::reset(run, ++number_, edges_.size());
  RunAccess::set_node(run, id_);
  RunAccess::set_threads(run, threads_planned());
  binding_->own->number.store(number_, std::memory_order_relaxed);
  if (thread_ == 0) thread_ = static_cast<std::int32_t>(os_.current_thread());
  counted_early_ = std::exchange(has_waited_, false) && own_cpu_ && !has_other_threads();
  begin_cpu_ = counted_early_ ? *own_cpu_ : os_.thread_cpu_time();
  others_.begin();
  read_other_threads();
  wait_.begin();
  if (run.threads() > 1) begin_ready_ = ready_time();
  begin_ = os_.now();
  RunAccess::begin(run, begin_, edges_);
  for (std::size_t input = 0; input < edges_.size(); ++input) RunAccess::set_taken_before(run, input, origins_[input]);
  consume_newest(run);
  RunAccess::take_limited(run);
}

void NodePort::Runs::consume_newest(Run& run) {
  for (std::size_t input = 0; input < edges_.size(); ++input) {
    const NodeCell* const predecessor = binding_->predecessors[input];
    if (predecessor != nullptr && edges_[input].channel == nullptr) consume_newest(run, input, *predecessor);
  }
}

void NodePort::Runs::consume_newest(Run& run, std::size_t input, const NodeCell& predecessor) {
  // That of the newest output is unknown only if the predecessor gave another since, which is then the newest.
  constexpr int kTries = 3;
  const bool is_queue = node_.input == graph::InputKind::kQueue;
  std::uint64_t newest = 0;
  std::int64_t origin = NodeCell::kUnknown;
  const std::uint64_t before = taken_[input];
  for (int tried = 0; tried < kTries && origin == NodeCell::kUnknown; ++tried) {
    newest = predecessor.newest_output.load(std::memory_order_acquire);
    if (newest == 0 || (is_queue && newest <= before)) break;
    origin = is_queue ? predecessor.oldest_origin(before + 1, newest) : predecessor.origin_of(newest);
  }
  taken_[input] = newest;
  if (newest == 0 || (is_queue && newest <= before)) return;
  RunAccess::Origin known{origin};
  if (origin == NodeCell::kUnknown) known = std::max(origins_[input], RunAccess::Origin{0});
  RunAccess::consume(run, input, is_queue ? before + 1 : newest, newest, known);
}

// A message may be there before the run that sent it has ended.
void NodePort::Runs::take(Run& run, std::string_view from, std::uint64_t first, std::uint64_t last) {
  const auto edge = std::find_if(edges_.begin(), edges_.end(), [&](const auto& one) { return one.from == from; });
  if (edge == edges_.end() || edge->channel != nullptr) return;
  const auto input = static_cast<std::size_t>(edge - edges_.begin());
  const NodeCell* const predecessor = binding_->predecessors[input];
  if (predecessor == nullptr) return;
  last = std::min(last, predecessor->newest_output.load(std::memory_order_acquire));
  if (last == 0 || first == 0) return;
  first = std::min(first, last);
  const std::int64_t origin = first == last ? predecessor->origin_of(last) : predecessor->oldest_origin(first, last);
  RunAccess::Origin known{origin};
  if (origin == NodeCell::kUnknown) known = std::max(origins_[input], RunAccess::Origin{0});
  taken_[input] = last;
  RunAccess::consume(run, input, first, last, known);
}

// Whether the run gives output, what that goes back to, and what the next one needs to know.
RunAccess::Origin NodePort::Runs::settle_ages(Run& run) {
  RunAccess::skip_if_stale(run);
  for (std::size_t input = 0; input < edges_.size(); ++input) origins_[input] = RunAccess::inputs(run)[input].origin;
  const RunAccess::Origin oldest = RunAccess::oldest_consumed(run);
  if (oldest != RunAccess::kNoOrigin) origin_ = oldest;
  return is_source_ || origin_ == RunAccess::kNoOrigin ? begin_.time_since_epoch() : origin_;
}

void NodePort::Runs::end(Run& run) {
  own_cpu_ = os_.thread_cpu_time();
  read_other_threads();
  Nanos cpu = std::max(*own_cpu_ - begin_cpu_, Nanos{0}) + others_.used();
  end_ = os_.now();
  // One thread cannot take longer than the clock says, whatever it did between its trigger and begin().
  if (counted_early_) cpu = std::min(cpu, end_ - begin_ + kStraightBack);
  const RunAccess::Origin origin = settle_ages(run);
  MeasuredRun measured{
      .begin = begin_, .end = end_, .cpu = cpu, .wait = wait_.end(end_ - begin_, cpu), .on_cpu = os_.current_cpu()};
  if (run.threads() > 1) {
    measured.elapsed = std::max(end_ - begin_ - measured.wait - (ready_time() - begin_ready_), Nanos{0});
  }
  encode_report(run, measured, words_);
  binding_->reports.push(words_);
  RunAccess::finish_writes(run, origin);
  if (RunAccess::emits(run)) binding_->own->give(run.number(), origin.count());
  pass_on(RunAccess::emits(run));
}

void NodePort::Runs::pass_on(bool emits) {
  if (binding_->next != nullptr && emits) {
    binding_->next->word.store(low(token_), std::memory_order_release);
    os_.wake(binding_->next->word);
  } else if (binding_->signal != nullptr) {
    if (emits) binding_->signal->give_output(os_, *binding_->region, end_);
    complete(os_, *binding_->region, *binding_->signal, token_);
  } else if (emits) {
    for (NodeCell* const follower : binding_->followers) {
      follower->word.fetch_add(1, std::memory_order_release);
      os_.wake(follower->word);
    }
    binding_->own->led.give_output(os_, *binding_->region, end_);
  }
}

int NodePort::Runs::threads_planned() const {
  const int max = node_.max_threads;
  const int planned = binding_->signal != nullptr ? binding_->signal->threads.load(std::memory_order_relaxed) : 0;
  return planned > 0 ? std::min(planned, max) : max;
}

// 0: the system does not tell.
Nanos NodePort::Runs::ready_time() { return os_.ready_time().value_or(Nanos{0}); }

bool NodePort::Runs::has_other_threads() const {
  const NodeCell& own = *binding_->own;
  const std::uint32_t count = own.threads.load(std::memory_order_acquire);
  return count > 1 || (count == 1 && own.thread[0].load(std::memory_order_acquire) != thread_);
}

void NodePort::Runs::read_other_threads() {
  NodeCell& own = *binding_->own;
  const auto count = std::min<std::size_t>(own.threads.load(std::memory_order_acquire), NodeCell::kMaxThreads);
  for (std::size_t index = 0; index < count; ++index) {
    const std::int32_t thread = own.thread[index].load(std::memory_order_acquire);
    if (thread == 0 || thread == thread_) continue;
    if (const Result<Nanos> used = os_.thread_cpu_time(os::ThreadId{thread})) {
      others_.read(os::ThreadId{thread}, *used);
    } else {
      own.thread[index].store(0, std::memory_order_release);  // it has ended
    }
  }
}

}  // namespace ctn::runtime
