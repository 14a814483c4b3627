// What the response times of a chain came to, as plain values: how many were late, by which causes, and the longest of
// them taken apart. docs/why.md defines each word.
//
// Units: in the types and names. Thread safety: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"
#include "catan/summary.h"
#include "graph/app.h"
#include "why/parts.h"

namespace ctn::why {

// A part as it is over all responses: the sum of all its stretches in one.
struct UsualPart {
  PartKind kind = PartKind::kUnexplained;
  NodeId node;  // of pre-empted and stolen: by whom; else whose
  Nanos median{0};
};

struct Analysis {
  std::size_t term = 0;  // of the objective
  std::uint64_t responses = 0;
  Summary response_ms;
  std::optional<Nanos> bound{};
  Nanos late_over{0};                               // the bound, or the 99th percentile
  std::uint64_t late = 0;                           // longer than that
  std::array<std::uint64_t, kCauseKinds> causes{};  // of the late ones, by CauseKind
  std::uint64_t explained = 0;                      // responses of which at most 2 % are unexplained
  std::vector<UsualPart> usual{};                   // whose median is not 0, the longest first
  std::vector<Response> worst{};                    // the longest first
};

// The causes that late responses have, and how many have each: the most frequent first.
std::vector<std::pair<CauseKind, std::uint64_t>> causes_by_count(const Analysis& analysis);

// A kind of part, and whose: by whom of those that pre-empted and stole, else the part's node.
std::pair<PartKind, NodeId> whose(const Part& part);

// "pre-empted (LM by GL), 8.132 ms beyond what is usual". Names are as the app has them.
std::string in_words(const Cause& cause, const graph::Graph& graph);

}  // namespace ctn::why
