#include "why/analysis.h"

#include <fmt/format.h>

#include <algorithm>

namespace ctn::why {

std::vector<std::pair<CauseKind, std::uint64_t>> causes_by_count(const Analysis& analysis) {
  std::vector<std::pair<CauseKind, std::uint64_t>> counts;
  for (std::size_t kind = 0; kind < kCauseKinds; ++kind) {
    if (analysis.causes[kind] > 0) counts.emplace_back(static_cast<CauseKind>(kind), analysis.causes[kind]);
  }
  std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  return counts;
}

std::pair<PartKind, NodeId> whose(const Part& part) {
  const bool by_another = part.kind == PartKind::kPreEmpted || part.kind == PartKind::kStolen;
  return {part.kind, by_another ? part.by.value_or(part.node) : part.node};
}

std::string in_words(const Cause& cause, const graph::Graph& graph) {
  return fmt::format("{} ({}{}), {:.3f} ms beyond what is usual", to_string(cause.kind), graph.node(cause.node).name,
                     cause.by ? " by " + graph.node(*cause.by).name : "", to_millis(cause.beyond_usual).count());
}

}  // namespace ctn::why
