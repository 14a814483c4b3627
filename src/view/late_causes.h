// Why responses were late, found out while the app runs: each gets one cause from the fixed list of docs/why.md.
//
// The events of the last seconds are kept. Only when responses were late are these events analysed (why::Analyser), at
// most once every kEvery of the app's time: as long as no response is late, this costs no more than keeping events. The
// caller decides which responses are late. What is usual for a chain, against which causes are found, is taken from the
// kept seconds.
//
// Units: instants of the monotonic clock. Thread safety: none; one owner. Memory: the events of kKept, and at most
// kMaxKept of them.
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
  static constexpr std::size_t kMaxKept = 65536;
  static constexpr std::size_t kMaxWaiting = 16384;
  // Events that belong to a response may be reported this long after its end.
  static constexpr Nanos kSettled = std::chrono::seconds{1};

  using Counts = std::array<std::uint64_t, why::kCauseKinds>;  // by CauseKind

  // The counts of a chain, for another LateCauses that takes over from this one.
  struct SoFar {
    Counts counts{};
    TimePoint until{};  // end of the newest response that was counted
  };
  struct Told {
    TimePoint end{};
    why::CauseKind cause = why::CauseKind::kUnexplained;
  };

  // Chains are numbered below as the response times of the objective, in its order.
  LateCauses(const graph::App& app, std::size_t cpus);

  // Events, in the order in which they were reported.
  template <class Event>
  void add(const Event& event) {
    keep(event);
  }
  // A response of the chain was late; the run that was added last has ended it.
  void late(std::size_t chain, TimePoint begin, TimePoint end);
  // Finds causes, if that is due. `app`: the one of the constructor; its weights and bounds may have changed.
  void look(const graph::App& app);
  // Finds causes for all that are left, since no more events are to come for now.
  void look_at_all(const graph::App& app) { explain(app, TimePoint::max()); }
  // Events were lost after what was added so far.
  void lost(const graph::App& app);

  // Of one chain: the responses of the last kKept whose causes are known, by their ends; and the counts of all since
  // this was made, with those that it took over.
  const std::deque<Told>& told(std::size_t chain) const { return told_[chain]; }
  const Counts& counts(std::size_t chain) const { return so_far_[chain].counts; }

  const std::vector<SoFar>& so_far() const { return so_far_; }  // by chain
  // Call it before anything is added. `other`: of the same app.
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
  // Finds the causes of waiting responses that ended by then.
  void explain(const graph::App& app, TimePoint by);
  void tell(std::size_t chain, TimePoint end, why::CauseKind cause);

  std::vector<std::size_t> terms_;  // by chain
  std::size_t cpus_;
  std::deque<Event> events_;
  std::map<NodeId, record::ClockReading> clocks_;  // the last ones that are no longer in events_
  std::optional<record::PlanChange> plan_;         // likewise
  std::deque<Waiting> waiting_;
  std::vector<std::deque<Told>> told_;  // by chain
  std::vector<SoFar> so_far_;           // by chain
  std::vector<TimePoint> before_;       // by chain: responses that ended until then are in the counts taken over
  TimePoint newest_{};
  std::optional<TimePoint> looked_;
};

}  // namespace ctn::view
