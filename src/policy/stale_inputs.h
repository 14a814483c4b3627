// When to tell that a node works on data that is older than its edge's `max_age`: when that begins, and when it is
// over, not at each run. It is over when no run had old data for kCalm, so that an age near its limit gives no more
// than two notices in that time.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "graph/app.h"
#include "record/events.h"

namespace ctn::policy {

class StaleInputs {
 public:
  static constexpr Nanos kCalm = std::chrono::seconds{1};

  // `graph` outlives it.
  explicit StaleInputs(const graph::Graph& graph);

  // A run has ended, whose ages are known; runs of a node in their order. What is to be told, if anything.
  std::vector<record::Notice> ran(const record::Run& run);

 private:
  struct Episode {
    std::uint64_t runs = 0;  // with old data
    Nanos oldest{0};
    TimePoint last{};  // begin of the newest of these
  };
  struct Input {
    std::size_t index = 0;  // among the predecessors
    graph::Edge edge;       // with a limit
    std::optional<Episode> episode;
  };

  std::optional<record::Notice> look(Input& input, const record::Run& run) const;

  const graph::Graph& graph_;
  std::vector<std::vector<Input>> inputs_;  // by NodeId: those with a limit
};

}  // namespace ctn::policy
