#include "runtime/report.h"

#include <cassert>

namespace ctn::runtime {
namespace {

// Above 32 bits of mode and one that says whether the run gave output.
constexpr unsigned kCpuShift = 33;
constexpr unsigned kCpuBits = 16;
constexpr unsigned kThreadsShift = kCpuShift + kCpuBits;

Nanos age_of(TimePoint begin, TimePoint origin) {
  if (origin < TimePoint{}) return record::kNoAge;
  return begin > origin ? begin - origin : Nanos{0};
}

}  // namespace

void encode_report(const Run& run, const MeasuredRun& measured, std::span<std::uint64_t> words) {
  assert(words.size() == report_words(RunAccess::inputs(run).size()));
  words[0] = run.number();
  words[1] = to_word(measured.begin);
  words[2] = to_word(measured.end);
  words[3] = static_cast<std::uint64_t>(measured.cpu.count());
  words[4] = (static_cast<std::uint64_t>(run.threads()) << kThreadsShift) |
             (static_cast<std::uint64_t>(measured.on_cpu + 1) << kCpuShift) |
             (std::uint64_t{RunAccess::mode(run)} << 1U) | (RunAccess::emits(run) ? 1U : 0U);
  words[5] = static_cast<std::uint64_t>(measured.wait.count());
  words[6] = static_cast<std::uint64_t>(measured.elapsed.count());
  std::size_t word = report_words(0);
  for (const RunAccess::Input& input : RunAccess::inputs(run)) {
    words[word++] = input.first;
    words[word++] = input.last;
    words[word++] = static_cast<std::uint64_t>(input.origin.count());
  }
}

record::Run decode_report(NodeId node, std::span<const NodeId> predecessors, std::span<const std::uint64_t> words) {
  assert(words.size() == report_words(predecessors.size()));
  record::Run run;
  run.node = node;
  run.number = words[0];
  run.begin = to_time(words[1]);
  run.end = to_time(words[2]);
  run.cpu = Nanos{static_cast<Nanos::rep>(words[3])};
  run.mode = static_cast<std::uint32_t>(words[4] >> 1U);
  run.on_cpu = static_cast<int>((words[4] >> kCpuShift) & ((1U << kCpuBits) - 1)) - 1;
  run.threads = static_cast<int>(words[4] >> kThreadsShift);
  run.emitted = (words[4] & 1U) != 0;
  run.wait = Nanos{static_cast<Nanos::rep>(words[5])};
  run.elapsed = Nanos{static_cast<Nanos::rep>(words[6])};
  std::size_t word = report_words(0);
  for (const NodeId predecessor : predecessors) {
    const std::uint64_t first = words[word++];
    const std::uint64_t last = words[word++];
    if (first != 0) run.consumed.push_back({predecessor, first, last});
    run.ages.push_back(age_of(run.begin, to_time(words[word++])));
  }
  return run;
}

}  // namespace ctn::runtime
