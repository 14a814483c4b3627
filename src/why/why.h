// Why responses of a chain were late: takes each response time of a recorded run apart, along the path that its
// outputs came, and gives each late one a cause.
//
//   Result<Analysis> analysis = analyse(record, term, {.worst = 5});      // or, event by event, an Analyser
//
// How it works:
//   history.h   what happened, in memory
//   walk.h      takes one response time apart, such that its parts add up to it
//   causes.h    what is usual of each part, over all responses, and so what made the late ones late
//   json.h      an analysis as JSON
// A response time is what record/lineage.h measures: from the begin of a run of the chain's first node to the end of
// the output that goes back to it, and on to the end of the next output (with clocks of others: their ticks).
//
// Late is a response longer than the chain's bound; of a chain without one, longer than the 99th percentile of its own
// responses. docs/why.md defines parts and causes.
//
// Units: in the types. Thread safety: none; one owner. Memory: about 100 bytes a run of the app, 300 a response.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "catan/summary.h"
#include "graph/app.h"
#include "record/lineage.h"
#include "record/reader.h"
#include "record/run_metrics.h"
#include "why/history.h"
#include "why/parts.h"
#include "why/walk.h"

namespace ctn::why {

// Which term of the objective is meant by a number, a path ("scan>LM", "scan -> LM") or a last node. kCaller: none, or
// several; it says which there are.
Result<std::size_t> find_chain(const graph::App& app, std::string_view chain);

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

struct Options {
  std::size_t worst = 5;
  bool whole = false;  // the warm-up is included
};

// What a record says of a chain, event by event.
class Analyser {
 public:
  // `app` outlives it. Precondition: the term is a response time.
  Analyser(const graph::App& app, std::size_t term, std::size_t cpus, const record::Interval& measured);

  // In the order that record::ChainTracker wants.
  void add(const record::Run& run);
  // Before the runs that end later.
  void add(const record::ClockReading& reading);
  // In any order.
  void add(const record::Trigger& trigger) { history_.add(trigger); }
  void add(const record::SlotUse& slot) { history_.add(slot); }
  void add(const record::Steal& steal) { history_.add(steal); }
  Status add(const record::PlanChange& change) { return history_.add(change); }

  // Once, after all events: with the `worst` longest responses taken apart.
  Analysis finish(std::size_t worst);
  // After finish(): all responses, by their ends, each taken apart as it is asked for.
  std::size_t responses() const { return ends_.size(); }
  Response response(std::size_t index);

 private:
  struct Known {
    record::ChainSample sample;
    std::size_t path = 0;  // where it begins in paths_
  };
  std::optional<std::size_t> stage_of(NodeId node) const;
  Way way(const Known& known) const;

  const graph::App& app_;
  std::size_t term_;
  record::Interval measured_;
  History history_;
  Chain chain_;
  record::ChainTracker tracker_;
  std::vector<Known> samples_;
  std::vector<std::uint64_t> paths_;          // numbers of runs, a path after the other
  std::vector<std::size_t> ends_;             // the samples that end a response which counts
  std::vector<std::optional<Cause>> causes_;  // of ends_
  Nanos late_over_{0};
};

// Errors: those of the reader; a plan in the record that cannot be read (kCaller). Precondition: as Analyser has it.
Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options);

}  // namespace ctn::why
