// What runs cost in a real run, from its record: the same again, run by run, or drawn from among them.
//
// Units: as run_costs.h. Memory: 24 bytes a recorded run. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/reader.h"
#include "sim/run_costs.h"

namespace ctn::sim {

// The runs of a record, by node of the app that is simulated.
struct RecordedRuns {
  struct Cost {
    Nanos cpu{0};
    std::uint32_t mode = 0;
    Nanos wait{0};
  };
  std::vector<std::vector<Cost>> by_node;

  // Errors: the reader's; a node that is not external and has no run in the record (kCaller).
  static Result<RecordedRuns> read(const record::Reader& record, const graph::App& app);
};

class RecordedCosts : public RunCosts {
 public:
  // A node's n-th run costs what its n-th in the record did, from the beginning again when these are used up; or what
  // any of them did, drawn at random from the seed.
  enum class Order { kAsRecorded, kDrawn };

  // `overhead`: what of a recorded run's CPU time the simulated machine adds by itself. What was recorded is taken to
  // be of a core of speed 1, and of as many threads as the simulated run has.
  RecordedCosts(const graph::App& app, std::shared_ptr<const RecordedRuns> runs, Order order, std::uint64_t seed,
                Nanos overhead);

  int threads_used(NodeId, int max) const override { return max; }
  model::RunDraw draw(NodeId node, std::uint64_t number, Nanos since_start, int threads, std::size_t kind) override;

 private:
  std::shared_ptr<const RecordedRuns> runs_;
  Order order_;
  std::uint64_t seed_;
  Nanos overhead_;
  std::vector<double> speeds_;  // by kind
};

}  // namespace ctn::sim
