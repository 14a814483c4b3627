// Why responses were late, told while the app runs: each late one gets one cause from the fixed list of docs/why.md.
//
// The events of the last seconds are kept, and only where a response was late is it looked for why
// (why::Analyser), at most each kEvery of the app's time: where none is late it costs no more than keeping them. Which
// response is late is the caller's to say. What is usual of a chain, which causes are told by, is that of the kept
// seconds.
//
// Units: instants of the monotonic clock. Thread safety: none; one owner. Memory: the events of kKept, and at most
// kMostKept of them.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "record/events.h"
#include "why/parts.h"

namespace ctn::view {

class LateCauses {
 public:
  static constexpr Nanos kEvery = std::chrono::seconds{5};
  static constexpr Nanos kKept = std::chrono::seconds{15};
  static constexpr std::size_t kMostKept = 65536;
  static constexpr std::size_t kMostWaiting = 16384;
  // What took part in a response may be told so much later than its end.
  static constexpr Nanos kSettled = std::chrono::seconds{1};

  using Counts = std::array<std::uint64_t, why::kCauseKinds>;  // by CauseKind

  // What was counted of a chain, for another that goes on where this one ends.
  struct SoFar {
    Counts counts{};
    TimePoint until{};  // end of the newest response that is among them
  };
  struct Told {
    TimePoint end{};
    why::CauseKind cause = why::CauseKind::kUnexplained;
  };

  // Chains: the response times of the objective, in its order.
  LateCauses(const graph::App& app, std::size_t cpus);

  // What has happened, in the order in which it was told.
  template <class Event>
  void add(const Event& event) {
    keep(event);
  }
  // A response of the chain, which the run that was added last has ended, was late.
  void late(std::size_t chain, TimePoint begin, TimePoint end);
  // Looks why, if that is due. `app`: the one that this was made for; weights and bounds do not matter.
  void look(const graph::App& app);
  // Looks at all that are left: nothing more will come for now.
  void look_at_all(const graph::App& app) { explain(app, TimePoint::max()); }
  // Events were lost after what was added so far.
  void lost(const graph::App& app);

  // Of one chain: those that are known, of the last kKept, by their ends; and all since this was made.
  const std::deque<Told>& told(std::size_t chain) const { return told_[chain]; }
  const Counts& counts(std::size_t chain) const { return so_far_[chain].counts; }

  const std::vector<SoFar>& so_far() const { return so_far_; }  // by chain
  // Before anything is added; of the same app.
  void go_on_from(const std::vector<SoFar>& other);

 private:
  using Event = std::variant<record::Run, record::Trigger, record::SlotUse, record::Steal, record::ClockReading,
                             record::PlanChange>;
  struct Waiting {
    std::size_t chain = 0;
    TimePoint begin{};
    TimePoint end{};
  };

  void keep(Event event);
  void forget_oldest();
  // Those that ended by then.
  void explain(const graph::App& app, TimePoint by);
  void tell(std::size_t chain, TimePoint end, why::CauseKind cause);

  std::vector<std::size_t> terms_;  // by chain
  std::size_t cpus_;
  std::deque<Event> events_;
  std::map<NodeId, record::ClockReading> clocks_;  // before these
  std::optional<record::PlanChange> plan_;         // the same
  std::deque<Waiting> waiting_;
  std::vector<std::deque<Told>> told_;  // by chain
  std::vector<SoFar> so_far_;           // by chain
  std::vector<TimePoint> before_;       // by chain: what ended until then was counted before this was made
  TimePoint newest_{};
  std::optional<TimePoint> looked_;
};

}  // namespace ctn::view
