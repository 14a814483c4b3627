// What is known of the clocks of others, from the housekeeping thread to the controllers, which never wait.
//
// How: two places a clock, of which one counts; the other is written. A reader that is overtaken twice while it reads
// may see half of each, which a few ticks later cannot be told from the clock's drift.
//
// Thread safety: one writer, any number of readers.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/ticks.h"

namespace ctn::runtime {

class ClockBoard {
 public:
  explicit ClockBoard(std::size_t nodes) : clocks_(nodes) {}

  void write(NodeId node, const Ticks& ticks) {
    Clock& clock = clocks_[node.index()];
    const std::uint32_t next = clock.written.load(std::memory_order_relaxed) + 1;
    Place& place = clock.places[next % 2];
    place.tick.store(ticks.tick.time_since_epoch().count(), std::memory_order_relaxed);
    place.period.store(ticks.period.count(), std::memory_order_relaxed);
    place.number.store(ticks.number, std::memory_order_relaxed);
    clock.written.store(next, std::memory_order_release);
  }

  // None: nothing was written yet.
  std::optional<Ticks> read(NodeId node) const {
    const Clock& clock = clocks_[node.index()];
    const std::uint32_t written = clock.written.load(std::memory_order_acquire);
    if (written == 0) return std::nullopt;
    const Place& place = clock.places[written % 2];
    return Ticks{TimePoint{Nanos{place.tick.load(std::memory_order_relaxed)}},
                 Nanos{place.period.load(std::memory_order_relaxed)}, place.number.load(std::memory_order_relaxed)};
  }

 private:
  struct Place {
    std::atomic<std::int64_t> tick{0};
    std::atomic<std::int64_t> period{0};
    std::atomic<std::int64_t> number{0};
  };
  struct Clock {
    std::atomic<std::uint32_t> written{0};
    std::array<Place, 2> places{};
  };

  std::vector<Clock> clocks_;  // by NodeId
};

}  // namespace ctn::runtime
