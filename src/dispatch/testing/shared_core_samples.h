// Schedules of a shared core in a few words; for tests. Subchains are named by their index, which is their rank too.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/testing/times.h"
#include "dispatch/shared_core_schedule.h"
#include "dispatch/testing/virtual_core.h"

namespace ctn::dispatch {

inline SharedCoreSlot every(int frames, int subchain, Nanos slice, int phase = 0) {
  return {.subchain = SubchainId(static_cast<std::size_t>(subchain)),
          .slice = slice,
          .every = frames,
          .phase = phase,
          .share = 1.0 / frames,
          .rank = subchain};
}

inline SharedCoreSlot queue(double share, int subchain, Nanos slice) {
  SharedCoreSlot slot = every(1, subchain, slice);
  slot.every.reset();
  slot.share = share;
  return slot;
}

inline SharedCoreSchedule elastic(std::vector<SharedCoreSlot> slots, double slack = 0.2, Nanos frame_min = Nanos{0}) {
  return {.frames = graph::FrameMode::kElastic, .frame_min = frame_min, .slack = slack, .slots = std::move(slots)};
}

// Slots one after the other.
inline SharedCoreSchedule fixed(std::vector<SharedCoreSlot> slots, Nanos frame, double slack = 0.2) {
  Nanos offset{0};
  for (SharedCoreSlot& slot : slots) {
    slot.offset = offset;
    offset += slot.slice;
  }
  return {.frames = graph::FrameMode::kFixed, .frame = frame, .slack = slack, .slots = std::move(slots)};
}

inline SharedCoreSchedule without_stealing(SharedCoreSchedule schedule) {
  for (SharedCoreSlot& slot : schedule.slots) slot.may_steal = false;
  return schedule;
}

// Milliseconds of each run, by subchain; the last one goes on.
inline VirtualCore::Cost costs(std::vector<std::vector<double>> by_subchain) {
  return [by_subchain = std::move(by_subchain)](SubchainId subchain, std::uint64_t number) {
    const std::vector<double>& runs = by_subchain.at(subchain.index());
    return ms(runs[std::min<std::size_t>(number, runs.size()) - 1]);
  };
}

}  // namespace ctn::dispatch
