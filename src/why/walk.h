// Takes a response time apart: walks back from its end to its begin, along the runs that its outputs go back to, and
// says of each stretch of time what it was spent on. Each step begins where the one before ended, so the parts add up.
//
//   in a run         when it computed, waited for a device, and did not have its core; and which node had it then
//                    (run_parts.h)
//   before a run     from when it could have begun (its trigger, or the end of the run that triggers it): which node
//                    had the core, the node's previous run, slots of other subchains
//   before that      what triggered it: the run before it in its subchain, the run of its leader, or a trigger that was
//                    due and was sent late; and before that, what the trigger was due after
//
// Units: in the types. Thread safety: none; one owner. A response takes as many steps as there are runs on its path.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "record/lineage.h"
#include "why/history.h"
#include "why/parts.h"
#include "why/run_parts.h"

namespace ctn::why {

// The nodes of a chain that are not external: its stages.
struct Chain {
  std::vector<NodeId> nodes;
  // By stage and run: the newest run of the stage before that it consumed; 0: none.
  std::vector<std::vector<std::uint64_t>> taken{};
  bool begins_at_clock = false;  // of an external node, one that is known
};

// How a sample reached the end of the chain: through which run of each stage.
struct Way {
  record::ChainSample sample;
  std::vector<std::size_t> runs;  // index among the node's runs, by stage
};

class Walk {
 public:
  // History and chain outlive it.
  Walk(const History& history, const Chain& chain) : history_(history), chain_(chain) {}

  // The parts of the response that ends with `way`'s output and begins with the source run of `before`.
  std::vector<Part> take_apart(const Way& before, const Way& way);

 private:
  struct LeftOut {
    TimePoint end;
    NodeId node;
  };

  void walk(const Way& way, const Way* before, TimePoint begin, TimePoint end);
  void emit(TimePoint from, PartKind kind, NodeId node, std::optional<NodeId> by = {});
  void emit(const std::vector<Delay>& delays, NodeId node);
  bool arrived() const { return cursor_ <= floor_; }

  void in_run(const RunRef& ref);

  void before_run(std::size_t stage, const Way& way, const Way* before);
  std::optional<LeftOut> left_out(std::size_t stage, const Way& way, const Way* before) const;
  void explain_begin(RunRef ref, bool of_source);
  TimePoint held_apart_until(SubchainId subchain, const SentTrigger& trigger) const;
  std::optional<RunRef> triggered_by(const RunRef& ref) const;
  std::optional<RunRef> before_due(SubchainId subchain);
  void by_timer(const RunRef& ref, bool of_source);
  void ready(const RunRef& ref, TimePoint since, PartKind otherwise = PartKind::kKernel);

  const History& history_;
  const Chain& chain_;
  std::vector<Part> parts_;  // the last first
  TimePoint cursor_{};       // what comes after it is explained already
  TimePoint floor_{};        // what comes before it is of no interest
};

}  // namespace ctn::why
