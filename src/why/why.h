// Why responses of a chain were late: takes each response time of a recorded run apart, along the runs that its outputs
// go back to, and gives each late one a cause.
//
//   Result<Analysis> analysis = analyse(record, term, {.worst = 5});      // or, event by event, an Analyser
//
// A record is read twice, for all chains together: first for what must be known of the whole run, then to take its
// responses apart as they come, and to forget what happened before them.
//
// How it works:
//   survey.h      what must be known of the whole run
//   history.h     what happened, in memory
//   responses.h   the response times of a chain, and how each came about
//   walk.h        takes one of them apart, such that its parts add up to it
//   causes.h      what is usual of each part, over all responses, and so what made the late ones late
//   tally.h       adds up the responses of a chain
//   analysis.h    the results, as plain values; json.h: as JSON
// A response time is what record/lineage.h measures: from the begin of a run of the chain's first node to the end of
// the output that goes back to it, and on to the end of the next output. (With clocks of others, it begins and ends at
// their ticks.)
//
// A response is late if it is longer than the chain's bound or, where the chain has none, longer than the 99th
// percentile of its own responses. docs/why.md defines parts and causes.
//
// Units: in the types. Thread safety: none; one owner. Memory: of a record, what survey.h and tally.h say, 16 bytes a
// trigger and a slot, and what happened during the longest response; of an Analyser that is to keep all, about 100
// bytes a run of the app and 300 a response.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/reader.h"
#include "record/run_metrics.h"
#include "why/analysis.h"
#include "why/history.h"
#include "why/responses.h"
#include "why/survey.h"
#include "why/tally.h"

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

// Analyses chains from events that are added one by one. What happened is kept until it is asked, or only as long as it
// is needed (analyse_meanwhile()).
class Analyser {
 public:
  // `app` outlives it. Precondition: the terms are response times.
  Analyser(const graph::App& app, const std::vector<std::size_t>& terms, std::size_t cpus,
           const record::Interval& measured);

  // To be called before events are added: all events but runs are added before the first run, and runs are forgotten
  // once all responses of their time have been taken apart. `survey`: of the same run, finished; it outlives the
  // analyser. `step`: runs after which responses are taken apart, at least.
  void analyse_meanwhile(const Survey& survey, std::size_t worst, std::size_t step = kStep);

  // In the order that record::ChainTracker wants.
  void add(const record::Run& run);
  // Before the runs that end later.
  void add(const record::ClockReading& reading);
  // In any order.
  void add(const record::Trigger& trigger) { history_.add(trigger); }
  void add(const record::SlotUse& slot) { history_.add(slot); }
  void add(const record::Steal& steal) { history_.add(steal); }
  Status add(const record::PlanChange& change) { return history_.add(change); }

  // To be called once, after all events. Returns the analysis of each term, with its `worst` longest responses taken
  // apart.
  std::vector<Analysis> finish(std::size_t worst);
  // The same, after analyse_meanwhile().
  std::vector<Analysis> finish();
  // Instead of finish(), where a quick answer about some seconds of a run is needed: the causes of these responses of
  // each term, which the caller knows to be late, given by their begin and end as record::ChainTracker has them. What
  // is usual is taken from some hundreds of the term's responses. A response that was not found in the events is
  // unexplained.
  std::vector<std::vector<CauseKind>> causes_of(const std::vector<std::vector<Span>>& late);

 private:
  static constexpr std::size_t kStep = 1U << 15U;

  void expect(const std::vector<Lengths>& lengths, std::size_t worst);
  void take_apart(TimePoint until);
  void forget();

  const graph::App& app_;
  std::vector<std::size_t> terms_;
  record::Interval measured_;
  History history_;
  std::vector<Responses> chains_;   // by place in terms_
  std::vector<Tally> tallies_;      // by place in terms_; empty: none yet
  const Survey* survey_ = nullptr;  // null: all is kept
  std::size_t step_ = kStep;
  std::size_t left_ = kStep;  // runs until then
};

// Of a history that is told of runs and clocks by its owner, who reads them for more than this: what else there is in
// the record. Errors: as below. The history is then to be sorted.
Status add_all_but_runs(const record::Reader& record, History& history);

// The analysis of each term, in a second reading of the record, after the one of the survey. `app`: as it was at the
// end of the run; it is that of the survey. Errors, preconditions: as below.
Result<std::vector<Analysis>> analyse(const record::Reader& record, const graph::App& app,
                                      const std::vector<std::size_t>& terms, const record::Interval& measured,
                                      const Survey& survey, std::size_t worst);

// The analysis of each term, in two readings of the record. Errors: those of the reader; a plan in the record that
// cannot be read (kCaller). Precondition: as Analyser has it.
Result<std::vector<Analysis>> analyse(const record::Reader& record, const std::vector<std::size_t>& terms,
                                      const Options& options);
Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options);

}  // namespace ctn::why
