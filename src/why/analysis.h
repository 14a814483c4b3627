// What the analysis of a chain's response times found, as plain values: how many were late, by which causes, and the
// longest of them taken apart. docs/why.md defines each word.
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

// What is usual of a part: the median, over all responses, of the sum of its stretches in one.
struct UsualPart {
  PartKind kind = PartKind::kUnexplained;
  NodeId node;  // of pre-empted and stolen: the node that did it; else the part's node
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
  std::vector<UsualPart> usual{};                   // parts whose median is not 0, the longest first
  std::vector<Response> worst{};                    // the longest first
};

// The causes of the late responses, with how many have each, the most frequent first.
std::vector<std::pair<CauseKind, std::uint64_t>> causes_by_count(const Analysis& analysis);

// The key by which parts are summed up: their kind and a node, of pre-empted and stolen the one that did it, else the
// part's node.
std::pair<PartKind, NodeId> whose(const Part& part);

// "pre-empted (LM by GL), 8.132 ms beyond what is usual". Names are not made printable.
std::string in_words(const Cause& cause, const graph::Graph& graph);

}  // namespace ctn::why
