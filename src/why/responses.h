// The response times of one chain: finds them as runs are added, and takes them apart once all events are known.
//
// Units: in the types. Thread safety: none; one owner. Memory: about 300 bytes a response.
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

  // To be called once, after all events: analyses the responses that lie wholly in `measured`, and takes the `worst`
  // longest apart. `history` has all events, and is sorted.
  Analysis analyse(const History& history, const record::Interval& measured, std::size_t worst);
  // Instead: the causes of responses that are known to be late, in their order (Analyser::causes_of()).
  std::vector<CauseKind> causes_of(const History& history, std::span<const Span> late) const;

 private:
  struct Known {
    record::ChainSample sample;
    std::size_t path = 0;  // where its path begins in paths_
  };
  std::optional<std::size_t> stage_of(NodeId node) const;
  Way way(const History& history, const Known& known) const;
  // The response that is ended by that sample, an index into samples_.
  Response response(const History& history, std::size_t end) const;
  // The index in samples_ of the sample that ends this response; nothing: none does.
  std::optional<std::size_t> find(const Span& response) const;
  Nanos length(std::size_t end) const { return samples_[end].sample.end - samples_[end - 1].sample.begin; }

  const graph::App& app_;
  std::size_t term_;
  Chain chain_;
  record::ChainTracker tracker_;
  std::vector<Known> samples_;
  std::vector<std::uint64_t> paths_;  // numbers of runs, one path after the other
};

}  // namespace ctn::why
