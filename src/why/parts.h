// What a response time consists of, and what made it late, as plain values. docs/why.md defines each word.
//
// Units: in the types. Thread safety: plain values, pure functions.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::why {

enum class PartKind : std::uint8_t {
  kWaitingForSample,
  kWaitingForTrigger,
  kLateTrigger,
  kLateTimer,
  kOwnPreviousRun,
  kPlanChange,
  kNoOutput,
  kWaitingForSlot,
  kStolen,
  kPreEmpted,
  kKernel,
  kRunning,
  kRunningLonger,
  kDevice,
  kWaitingForTick,
  kUnexplained,
};
constexpr std::size_t kPartKinds = static_cast<std::size_t>(PartKind::kUnexplained) + 1;
const char* to_string(PartKind kind);  // "waiting-for-sample"

// A stretch of a response time. The parts of one follow each other without gap or overlap.
struct Part {
  PartKind kind = PartKind::kUnexplained;
  TimePoint begin{};
  TimePoint end{};
  NodeId node;                 // the node whose run it is, or whose run is waited for
  std::optional<NodeId> by{};  // the node whose runs had the core meanwhile; none: no node of the app, or not known

  Nanos length() const { return end - begin; }
  friend bool operator==(const Part&, const Part&) = default;
};

enum class CauseKind : std::uint8_t {
  kLongRun,
  kPreEmpted,
  kWaitedForSlot,
  kStolen,
  kLateTrigger,
  kLateTimer,
  kWaitedForTrigger,
  kWaitedForSample,
  kWaitedForTick,
  kOwnPreviousRun,
  kDevice,
  kNoOutput,
  kPlanChange,
  kStarved,
  kUnexplained,
};
constexpr std::size_t kCauseKinds = static_cast<std::size_t>(CauseKind::kUnexplained) + 1;
const char* to_string(CauseKind kind);  // "long-run"

struct Cause {
  CauseKind kind = CauseKind::kUnexplained;
  NodeId node;                 // the node whose run or wait it is
  std::optional<NodeId> by{};  // the node that pre-empted or stole
  Nanos beyond_usual{0};       // how much its parts exceed their median; their whole length if the median is late
  friend bool operator==(const Cause&, const Cause&) = default;
};

struct Response {
  TimePoint begin{};
  TimePoint end{};
  std::uint64_t source_run = 0;  // of the chain's first node; the response begins with the source run before it
  bool late = false;
  std::optional<Cause> cause{};  // of a late one
  std::vector<Part> parts{};

  Nanos length() const { return end - begin; }
};

}  // namespace ctn::why
