// Takes a response time apart: walks back along the path that its outputs came, from the end to the begin, and says of
// each stretch of time what it went by with. Each step begins where the one before ended, so the parts add up.
//
//   in a run         what it computed, waited for a device, and who had its core meanwhile
//   before a run     since it could run (its trigger, or the run that triggers it): who had the core, its node's run
//                    before, others' slots
//   before that      what triggered it: the run before it in its subchain, the run of its leader, or a trigger that was
//                    due, and was sent late; and before that what it was due after
//
// Units: in the types. Thread safety: none; one owner. A response takes as many steps as runs lie on its path.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "record/lineage.h"
#include "why/history.h"
#include "why/parts.h"

namespace ctn::why {

// The nodes of a chain that are not external: its stages.
struct Chain {
  std::vector<NodeId> nodes;
  std::vector<std::vector<std::uint64_t>> taken{};  // by stage and run: the newest run of the stage before; 0: none
  bool begins_at_clock = false;                     // of others, as far as is known
};

// How a sample reached the end: its run of each stage.
struct Way {
  record::ChainSample sample;
  std::vector<std::size_t> runs;  // index among its node's, by stage
};

class Walk {
 public:
  // All outlive it.
  Walk(const History& history, const Chain& chain) : history_(history), chain_(chain) {}

  // The parts of the response that ends with `way`'s output and begins with the source run of `before`.
  std::vector<Part> take_apart(const Way& before, const Way& way);

 private:
  struct Piece {
    PartKind kind;
    Nanos length;
    std::optional<NodeId> by{};
  };
  struct Held {
    Span time;
    PartKind kind;
    std::optional<NodeId> by{};
  };
  struct LeftOut {
    TimePoint end;
    NodeId node;
  };

  void walk(const Way& way, const Way* before, TimePoint begin, TimePoint end);
  void emit(TimePoint from, PartKind kind, NodeId node, std::optional<NodeId> by = {});
  void emit(const std::vector<Held>& held, NodeId node);
  bool arrived() const { return cursor_ <= floor_; }

  void in_run(const RunRef& ref);
  std::vector<Piece> pieces(const RunRef& ref) const;
  std::vector<Held> claims(const RunRef& ref, Nanos not_running) const;

  void before_run(std::size_t stage, const Way& way, const Way* before);
  std::optional<LeftOut> left_out(std::size_t stage, const Way& way, const Way* before) const;
  void explain_begin(RunRef ref, bool of_source);
  TimePoint held_apart_until(SubchainId subchain, const SentTrigger& trigger) const;
  std::optional<RunRef> triggered_by(const RunRef& ref) const;
  std::optional<RunRef> before_due(SubchainId subchain);
  void by_timer(const RunRef& ref, bool of_source);
  void ready(const RunRef& ref, TimePoint since, PartKind nobody = PartKind::kKernel);
  std::vector<Held> held_up(const RunRef& ref, Span span) const;

  const History& history_;
  const Chain& chain_;
  std::vector<Part> parts_;  // the last first
  TimePoint cursor_{};       // all after it is explained
  TimePoint floor_{};        // what comes before is not asked
};

}  // namespace ctn::why
