#include "common/run_times.h"

namespace catan_ros {

std::unique_ptr<RunTimes> RunTimes::open(const std::string& path) {
  auto file = SharedFile<Nodes>::open(path);
  return file ? std::unique_ptr<RunTimes>(new RunTimes(std::move(file))) : nullptr;
}

void RunTimes::begin(std::string_view node, std::uint64_t run, std::int64_t now) {
  Node* const known = find_node(node, true);
  if (known == nullptr) return;
  Run& begun = known->runs[known->begun.load() % kRuns];
  begun.number.store(0, std::memory_order_release);
  begun.begin.store(now, std::memory_order_release);
  begun.end.store(0, std::memory_order_release);
  begun.number.store(run, std::memory_order_release);
  known->begun.fetch_add(1);
}

void RunTimes::end(std::string_view node, std::int64_t now) {
  Node* const known = find_node(node, false);
  if (known == nullptr) return;
  const std::uint64_t begun = known->begun.load();
  if (begun > 0) known->runs[(begun - 1) % kRuns].end.store(now, std::memory_order_release);
}

// The newest first: where the program was killed within a run, its place has another one soon.
std::uint64_t RunTimes::find(std::string_view node, std::int64_t time) const {
  const Node* const known = find_node(node, false);
  if (known == nullptr) return 0;
  const std::uint64_t begun = known->begun.load();
  for (std::uint64_t back = 1; back <= kRuns && back <= begun; ++back) {
    const Run& run = known->runs[(begun - back) % kRuns];
    const std::uint64_t number = run.number.load(std::memory_order_acquire);
    const std::int64_t first = run.begin.load(std::memory_order_acquire);
    const std::int64_t last = run.end.load(std::memory_order_acquire);
    // Another run may have taken its place meanwhile.
    if (number == 0 || run.number.load(std::memory_order_acquire) != number) continue;
    if (first <= time && (last == 0 || time <= last)) return number;
    if (first <= time) return 0;  // between two runs
  }
  return 0;
}

}  // namespace catan_ros
