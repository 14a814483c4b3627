// The response times of one chain: finds them as runs are added, and takes them apart once what happened in them is
// known.
//
// Units: in the types. Thread safety: none; one owner. Memory: about 300 bytes a response that was not forgotten.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "graph/app.h"
#include "record/lineage.h"
#include "record/run_metrics.h"
#include "why/analysis.h"
#include "why/history.h"
#include "why/survey.h"
#include "why/tally.h"
#include "why/walk.h"

namespace ctn::why {

class Responses {
 public:
  // `app` outlives it. Precondition: the term is a response time.
  Responses(const graph::App& app, std::size_t term);

  // In the order that record::ChainTracker requires.
  void add(const record::Run& run);
  // Before the runs that end later.
  void add(const record::ClockReading& reading);

  // For a chain that is taken apart while events are added: whether anything will be known of the clock that begins it.
  void expect_clock(const Survey& survey);

  // Of all that were added, those that lie wholly in `measured`: how long they are, in ms.
  std::vector<double> lengths_ms(const record::Interval& measured) const;

  // Adds the responses in `measured` that ended by then, and were not yet added, to the tally. `history` is sorted, and
  // has all that happened in them.
  void take_apart(const History& history, const record::Interval& measured, TimePoint until, Tally& tally);
  // Nothing that happened before then matters to responses that are still to be taken apart. Nothing: all may matter.
  std::optional<TimePoint> needs_from(const History& history) const;
  // Forgets the responses that were taken apart, and what it knows of runs that the history has forgotten
  // (History::forget_before()).
  void forget(const std::vector<std::size_t>& runs);

  // Instead: the causes of responses that are known to be late, in their order (Analyser::causes_of()).
  std::vector<CauseKind> causes_of(const History& history, std::span<const Span> late) const;

 private:
  std::optional<std::size_t> stage_of(NodeId node) const;
  Way way(const History& history, std::size_t sample) const;
  // The response that is ended by that sample, an index into samples_.
  Response response(const History& history, std::size_t end) const;
  // The index in samples_ of the sample that ends this response; nothing: none does.
  std::optional<std::size_t> find(const Span& response) const;
  Nanos length(std::size_t end) const { return samples_[end].end - samples_[end - 1].begin; }
  bool counts(std::size_t end, const record::Interval& measured) const;

  const graph::App& app_;
  std::size_t term_;
  Chain chain_;
  record::ChainTracker tracker_;
  std::vector<record::ChainSample> samples_;
  std::vector<std::uint64_t> paths_;  // numbers of runs, the path of one sample after the other
  std::size_t next_ = 1;              // the sample that ends the first response that was not taken apart
};

}  // namespace ctn::why
