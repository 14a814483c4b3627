// A run as a node reports it: a row of 64-bit words in a ring (word_ring.h), 7 and 3 for each predecessor: the
// runs that it consumed, from the first to the last, and the origin of its input (record/ages.h).
//
// Units: Nanos of the monotonic clock, which is one for all processes of a machine. Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/run_access.h"
#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::runtime {

constexpr std::size_t report_words(std::size_t predecessors) { return 7 + 3 * predecessors; }

inline std::uint64_t to_word(TimePoint time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); }
inline TimePoint to_time(std::uint64_t word) { return TimePoint{Nanos{static_cast<Nanos::rep>(word)}}; }

// What was measured of a run, as record::Run has it.
struct MeasuredRun {
  TimePoint begin{};
  TimePoint end{};
  Nanos cpu{0};
  Nanos wait{0};
  Nanos elapsed{0};
  int on_cpu = -1;
};

// Precondition: words.size() == report_words(inputs of the run).
void encode_report(const Run& run, const MeasuredRun& measured, std::span<std::uint64_t> words);
// Whatever the words are; nothing about them is believed yet.
record::Run decode_report(NodeId node, std::span<const NodeId> predecessors, std::span<const std::uint64_t> words);

}  // namespace ctn::runtime
