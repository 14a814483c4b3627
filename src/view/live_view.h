// Follows an app while it runs, by the events that its flight recorder keeps (flight/recording.h), and says what the
// app does at present. All of this is computed by the viewer (`catan top`, `catan http`); the app does not know of it.
//
// Figures are of a sliding window: the last kWindow, or as much of it as there are events for. What is drawn over time
// covers the last kHistory. Older events are forgotten, but for the plan in force, weights and bounds, clocks, and the
// newest notices. Late responses are counted by their causes (late_causes.h), some seconds after they ended.
//
// Units: Nanos and instants of the monotonic clock in, milliseconds out. Thread safety: none; one owner. Memory: at
// most kMaxSamples of each node, chain and subchain, the oldest of which go first, and that of record/lineage.h.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "plan/plan.h"
#include "plan/predicted_means.h"
#include "record/events.h"
#include "record/lineage.h"
#include "record/sink.h"
#include "record/writer.h"
#include "view/late_causes.h"
#include "view/picture.h"

namespace ctn::view {

constexpr Nanos kWindow = std::chrono::seconds{10};
constexpr Nanos kHistory = std::chrono::seconds{60};
constexpr Nanos kHistoryStep = std::chrono::seconds{1};
constexpr std::size_t kMaxSamples = 32768;
constexpr std::size_t kMaxEvents = 200;
// A session shows that it lives every 50 ms, from an ordinary thread.
constexpr Nanos kStalledAfter = std::chrono::seconds{1};

// What is known of the session itself.
struct Life {
  TimePoint seen_alive{};
  bool over = false;  // the run has ended in order
  bool gone = false;  // its process is no longer there
};

class LiveView final : public record::Sink {
 public:
  LiveView(graph::App app, const record::Header& header);

  // A run comes after those that it consumed. Events that hold until they are replaced may come again.
  void add(const record::Run& run) override;
  void add(const record::Trigger& trigger) override;
  void add(const record::SlotUse& slot) override;
  void add(const record::Steal& steal) override;
  void add(const record::Overrun& overrun) override;
  void add(const record::PlanChange& change) override;
  void add(const record::CostChange& change) override;
  void add(const record::AppChange& change) override;
  void add(const record::ClockReading& reading) override;
  void add(const record::Notice& notice) override;
  void set_totals(const record::Totals& totals) override { totals_ = totals; }
  // Events were lost between those added so far and the next ones: figures begin anew.
  void lost();

  // As of `now`, for which all events so far must have been added; where the session shows no sign of life, as of its
  // last one.
  Picture picture(TimePoint now, const Life& life) const;

  // The counts of late responses, for another LiveView that takes over the same run from this one.
  const std::vector<LateCauses::SoFar>& late_so_far() const { return late_.so_far(); }
  // Call it before anything is added.
  void go_on_from(const std::vector<LateCauses::SoFar>& late) { late_.go_on_from(late); }
  // The session has ended: finds out at once why the last responses were late.
  void ended() { late_.look_at_all(app_); }

  // With the weights and bounds that hold.
  const graph::App& app() const { return app_; }

 private:
  template <class Sample>
  using Series = std::deque<Sample>;  // in the order of adding, which is about that of ends

  struct RunSample {
    TimePoint begin{};
    TimePoint end{};
    Nanos cpu{0};
    Nanos wait{0};
    std::optional<Nanos> period;
    int on_cpu = -1;
  };
  struct KeptNode {
    Series<RunSample> runs;
    std::optional<TimePoint> last_end;
    std::optional<TimePoint> last_counted;  // end of the last run that counts for the period
  };
  // A run of a subchain up to one of its nodes.
  struct Step {
    std::uint64_t number = 0;
    TimePoint begin{};
    Nanos cpu{0};
  };
  struct Execution {
    TimePoint begin{};
    TimePoint end{};
    Nanos cpu{0};
  };
  struct TriggerSample {
    TimePoint end{};
    Nanos late{0};
  };
  struct KeptSubchain {
    Series<Execution> executions;
    Series<TriggerSample> triggers;
    Series<Execution> overruns;
  };
  struct Response {
    TimePoint begin{};  // of the source run that it counts from
    TimePoint end{};
    std::optional<Nanos> response;
    Nanos latency{0};
    std::optional<Nanos> period;
  };
  struct Worst {
    std::int64_t step = -1;  // since the clock's zero
    Nanos response{0};
  };
  struct KeptChain {
    std::size_t term = 0;
    record::ChainTracker tracker;
    Series<Response> responses;
    std::array<Worst, kHistory / kHistoryStep> worst{};
    std::optional<Nanos> newest{};
  };
  // What plans promised, to judge what began while they were in force.
  struct Promises {
    TimePoint at{};
    std::vector<std::optional<Millis>> responses;  // by chain
    std::vector<Millis> executions;                // by SubchainId
  };
  // A sample counts if its end lies in the window.
  struct Window {
    TimePoint from{};
    TimePoint to{};
    bool has(TimePoint end) const { return end > from && end <= to; }
    double seconds() const { return in_seconds(to - from); }
  };

  void seen(TimePoint at);
  void follow_subchain(const record::Run& run);
  bool is_late(std::size_t chain, TimePoint begin, Nanos response) const;
  void note(TimePoint at, std::string kind, std::string detail);
  double since_start(TimePoint at) const;
  const Promises* promised_at(TimePoint at) const;
  std::optional<int> cpu_of(int core) const;

  PlanInForce plan_in_force() const;
  Chain picture_of(const KeptChain& chain, std::size_t index, const Window& window) const;
  Subchain picture_of(SubchainId id, const Window& window) const;
  Node picture_of(NodeId id, const Window& window) const;
  std::vector<Core> cores(const Window& window) const;
  std::vector<Core> planned_cores() const;
  std::optional<double> objective(const Picture& picture) const;

  graph::App app_;
  record::Header header_;
  std::vector<KeptNode> nodes_;           // by NodeId
  std::vector<std::vector<Step>> steps_;  // by NodeId: by number modulo their count; empty: in no subchain
  std::vector<KeptSubchain> subchains_;   // by SubchainId
  std::vector<KeptChain> chains_;         // response times, in the order of the objective
  Series<record::SlotUse> slots_;
  Series<record::Steal> steals_;
  LateCauses late_;
  std::deque<Event> events_;
  std::deque<Promises> promises_;  // the oldest first
  std::optional<plan::Plan> plan_;
  std::vector<std::optional<plan::ChainPrediction>> predicted_;  // by it, by chain; empty: there is none
  std::string plan_json_;
  std::string plan_reason_;
  TimePoint plan_at_{};
  record::Totals totals_;
  std::optional<TimePoint> first_seen_;  // the first event after the last loss, or of all
  TimePoint newest_{};                   // event that was seen
  std::uint64_t lost_ = 0;
};

}  // namespace ctn::view
