// Notices late responses in the events that are read from a flight recorder, so that `catan watch` can save the last
// seconds when there is one.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/lineage.h"
#include "record/sink.h"

namespace ctn::flight {

// A response time of the objective that is watched.
struct WatchedChain {
  std::size_t term = 0;  // of the objective
  // A longer response is late. None: its bound counts, and where it has none, what the plan in force promises.
  std::optional<Nanos> over{};
};

struct LateResponse {
  std::size_t term = 0;
  Nanos response{0};
  Nanos over{0};    // what was exceeded
  TimePoint end{};  // of the response
};

class LateWatch : public record::PartialSink {
 public:
  using PartialSink::add;

  // Responses that began before `from` do not count. `app` outlives it. Precondition: the terms are response times.
  LateWatch(const graph::App& app, const std::vector<WatchedChain>& chains, TimePoint from);

  // Of the late responses since the last call, the one that exceeded its bound by most; none: there was none.
  std::optional<LateResponse> take();
  // How many were late since the last call of this.
  std::uint64_t take_count() { return std::exchange(count_, 0); }

  void add(const record::Run& run) override;
  void add(const record::PlanChange& change) override;
  void add(const record::AppChange& change) override;
  void add(const record::ClockReading& reading) override;

 private:
  struct Chain {
    WatchedChain watched;
    record::ChainTracker tracker;
    std::optional<Nanos> bound;
    std::optional<Nanos> promised;

    std::optional<Nanos> asked_or_promised() const;
  };

  const graph::App& app_;
  TimePoint from_;
  std::vector<Chain> chains_;
  std::optional<LateResponse> worst_;
  std::uint64_t count_ = 0;
};

}  // namespace ctn::flight
