// Why responses of a chain were late: takes each response time of a recorded run apart, along the runs that its outputs
// go back to, and gives each late one a cause.
//
//   Result<Analysis> analysis = analyse(record, term, {.worst = 5});      // or, event by event, an Analyser
//
// Several chains are analysed in one reading of the record, with one history.
//
// How it works:
//   history.h     what happened, in memory
//   responses.h   the response times of a chain, and how each came about
//   walk.h        takes one of them apart, such that its parts add up to it
//   causes.h      what is usual of each part, over all responses, and so what made the late ones late
//   analysis.h    the results, as plain values; json.h: as JSON
// A response time is what record/lineage.h measures: from the begin of a run of the chain's first node to the end of
// the output that goes back to it, and on to the end of the next output. (With clocks of others, it begins and ends at
// their ticks.)
//
// A response is late if it is longer than the chain's bound or, where the chain has none, longer than the 99th
// percentile of its own responses. docs/why.md defines parts and causes.
//
// Units: in the types. Thread safety: none; one owner. Memory: about 100 bytes a run of the app, 300 a response.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/reader.h"
#include "record/run_metrics.h"
#include "why/analysis.h"
#include "why/history.h"
#include "why/responses.h"

namespace ctn::why {

// The term of the objective that a number, a path ("scan>LM", "scan -> LM") or a last node names. kCaller: it names no
// chain, or several; the error lists the chains of the app.
Result<std::size_t> find_chain(const graph::App& app, std::string_view chain);

struct Options {
  std::size_t worst = 5;
  bool whole = false;  // the warm-up is included
};

// The terms of the objective that are response times: its chains.
std::vector<std::size_t> chains_of(const graph::App& app);

// Analyses chains from events that are added one by one.
class Analyser {
 public:
  // `app` outlives it. Precondition: the terms are response times.
  Analyser(const graph::App& app, const std::vector<std::size_t>& terms, std::size_t cpus,
           const record::Interval& measured);

  // Adds all events of a record but runs and readings of clocks. Errors: those of the reader; a plan that cannot be
  // read (kCaller).
  Status add_all_but_runs(const record::Reader& record);
  // In the order that record::ChainTracker wants.
  void add(const record::Run& run);
  // Before the runs that end later.
  void add(const record::ClockReading& reading);
  // In any order.
  void add(const record::Trigger& trigger) { history_->add(trigger); }
  void add(const record::SlotUse& slot) { history_->add(slot); }
  void add(const record::Steal& steal) { history_->add(steal); }
  Status add(const record::PlanChange& change) { return history_->add(change); }

  // To be called once, after all events. Returns the analysis of each term, with its `worst` longest responses taken
  // apart.
  std::vector<Analysis> finish(std::size_t worst);
  // What it was told of, after finish().
  std::shared_ptr<const History> history() const { return history_; }
  // Instead of finish(), where a quick answer about some seconds of a run is needed: the causes of these responses of
  // each term, which the caller knows to be late, given by their begin and end as record::ChainTracker has them. What
  // is usual is taken from some hundreds of the term's responses. A response that was not found in the events is
  // unexplained.
  std::vector<std::vector<CauseKind>> causes_of(const std::vector<std::vector<Span>>& late);

 private:
  record::Interval measured_;
  std::shared_ptr<History> history_;
  std::vector<Responses> chains_;
};

// The analysis of each term, in one reading of the record. Errors: those of the reader; a plan in the record that
// cannot be read (kCaller). Precondition: as Analyser has it.
Result<std::vector<Analysis>> analyse(const record::Reader& record, const std::vector<std::size_t>& terms,
                                      const Options& options);
Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options);

}  // namespace ctn::why
