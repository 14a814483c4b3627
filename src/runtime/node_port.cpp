#include "runtime/node_port.h"

#include <algorithm>

#include "runtime/run_access.h"

namespace ctn::runtime {
namespace {

std::uint64_t encode(TimePoint time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }
TimePoint decode_time(std::uint64_t word) { return TimePoint{Nanos{static_cast<Nanos::rep>(word)}}; }

}  // namespace

void SubchainSignal::complete(os::Os& os, std::uint64_t token) {
  std::uint64_t before = completed.load(std::memory_order_relaxed);
  while (before < token && !completed.compare_exchange_weak(before, token, std::memory_order_seq_cst)) {
  }
  // Sequentially consistent on both sides: either this sees the wish, or the holder sees the completion before it
  // sleeps.
  if (!wants_completions.load(std::memory_order_seq_cst)) return;
  if (Attention* const holder = listener.load(std::memory_order_seq_cst)) holder->nudge(os);
}

void SubchainSignal::thread_joined(os::Os& os) {
  threads_joined.fetch_add(1, std::memory_order_release);
  if (Attention* const holder = listener.load(std::memory_order_seq_cst)) holder->nudge(os);
}

void Attention::nudge(os::Os& os) {
  word.fetch_add(1, std::memory_order_release);
  os.wake(word);
}

NodePort::NodePort(os::Os& os, const graph::Graph& graph, NodeId node)
    : os_(os),
      node_(node),
      predecessor_ids_(graph.node(node).predecessors),
      predecessors_(predecessor_ids_.size(), nullptr),
      has_channel_(predecessor_ids_.size(), false),
      reports_(kReports, kFixedWords + 2 * predecessor_ids_.size()),
      encoded_(kFixedWords + 2 * predecessor_ids_.size()) {}

bool NodePort::wait_for_trigger() {
  const auto expected = static_cast<std::uint32_t>(token_);
  while (!stopping() && word_.load(std::memory_order_acquire) == expected) os_.wait(word_, expected, kNever);
  if (stopping()) return false;
  // Tokens only grow, so the low half tells how far.
  token_ += word_.load(std::memory_order_acquire) - expected;
  return true;
}

void NodePort::begin(Run& run) {
  RunAccess::reset(run, ++number_, predecessors_.size());
  begin_cpu_ = cpu_time_of_all_threads();
  begin_ = os_.now();
  for (std::size_t slot = 0; slot < predecessors_.size(); ++slot) {
    if (predecessors_[slot] == nullptr || has_channel_[slot]) continue;
    const std::uint64_t newest = predecessors_[slot]->newest_output();
    RunAccess::consume(run, slot, newest, newest);
  }
}

void NodePort::end(Run& run) {
  const Nanos cpu = cpu_time_of_all_threads() - begin_cpu_;
  report(run, os_.now(), std::max(cpu, Nanos{0}));
  RunAccess::finish_writes(run);
  if (RunAccess::emits(run)) newest_output_.store(run.number(), std::memory_order_release);

  if (next_ != nullptr && RunAccess::emits(run)) {
    next_->trigger(token_);
  } else if (signal_ != nullptr) {
    signal_->complete(os_, token_);
  }
}

void NodePort::report(const Run& run, TimePoint end, Nanos cpu) {
  encoded_[0] = run.number();
  encoded_[1] = encode(begin_);
  encoded_[2] = encode(end);
  encoded_[3] = static_cast<std::uint64_t>(cpu.count());
  encoded_[4] = (std::uint64_t{RunAccess::mode(run)} << 1U) | (RunAccess::emits(run) ? 1U : 0U);
  std::size_t word = kFixedWords;
  for (const RunAccess::Input& input : RunAccess::inputs(run)) {
    encoded_[word++] = input.first;
    encoded_[word++] = input.last;
  }
  reports_.push(encoded_);
}

record::Run NodePort::decode(std::span<const std::uint64_t> words) const {
  record::Run run;
  run.node = node_;
  run.number = words[0];
  run.begin = decode_time(words[1]);
  run.end = decode_time(words[2]);
  run.cpu = Nanos{static_cast<Nanos::rep>(words[3])};
  run.mode = static_cast<std::uint32_t>(words[4] >> 1U);
  run.emitted = (words[4] & 1U) != 0;
  for (std::size_t slot = 0; slot < predecessor_ids_.size(); ++slot) {
    const std::uint64_t first = words[kFixedWords + 2 * slot];
    const std::uint64_t last = words[kFixedWords + 2 * slot + 1];
    if (first != 0) run.consumed.push_back({predecessor_ids_[slot], first, last});
  }
  return run;
}

void NodePort::trigger(std::uint64_t token) {
  word_.store(static_cast<std::uint32_t>(token), std::memory_order_release);
  os_.wake(word_);
}

void NodePort::stop() {
  stopping_.store(true, std::memory_order_release);
  // Any change of the word wakes the node; it looks at the flag first.
  word_.fetch_add(1, std::memory_order_release);
  os_.wake(word_);
}

bool NodePort::add_thread(os::ThreadId thread) {
  const std::size_t index = thread_count_.fetch_add(1);
  if (index >= kMaxThreads) {
    thread_count_.store(kMaxThreads);
    return false;
  }
  threads_[index].store(static_cast<std::int32_t>(thread), std::memory_order_release);
  return true;
}

std::vector<os::ThreadId> NodePort::threads() const {
  std::vector<os::ThreadId> threads;
  for_each_thread([&](os::ThreadId thread) { threads.push_back(thread); });
  return threads;
}

Nanos NodePort::cpu_time_of_all_threads() {
  Nanos total = os_.thread_cpu_time();
  const std::size_t count = std::min(thread_count_.load(std::memory_order_relaxed), kMaxThreads);
  for (std::size_t index = 1; index < count; ++index) {
    const std::int32_t thread = threads_[index].load(std::memory_order_acquire);
    if (thread == 0) continue;
    if (const Result<Nanos> used = os_.thread_cpu_time(os::ThreadId{thread})) {
      total += *used;
    } else {
      threads_[index].store(0, std::memory_order_release);  // it has ended
    }
  }
  return total;
}

}  // namespace ctn::runtime
