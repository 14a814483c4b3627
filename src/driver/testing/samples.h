// Assignments in a few words; for tests. Slots as dispatch/testing/shared_core_samples.h has them.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "dispatch/testing/shared_core_samples.h"
#include "driver/testing/fake_world.h"

namespace ctn::driver {

using dispatch::every;

// Has its CPUs to itself, and is active on them.
inline policy::SubchainPlace paced(Nanos period, os::CpuSet cpus, Nanos hang_after = Nanos{0}) {
  policy::SubchainPlace place;
  place.cpus = std::move(cpus);
  place.pacing = {.period = period, .max_in_flight = 1, .hang_after = hang_after};
  place.level = os::Level::kActive;
  return place;
}

// Has a fixed priority on CPU 0, and is triggered by time.
inline policy::SubchainPlace phased(int rank, Nanos period, Nanos phase, Nanos budget = Nanos{0}) {
  policy::SubchainPlace place;
  place.cpus = os::CpuSet{0};
  place.pacing = {.period = period, .max_in_flight = 1, .phase = phase, .budget = budget};
  place.level = os::fixed_level(rank);
  return place;
}

// The same, triggered by the outputs of a leader.
inline policy::SubchainPlace follows(int rank, const plan::Leader& leader, int every, Nanos expected,
                                     Nanos budget = Nanos{0}) {
  policy::SubchainPlace place = phased(rank, expected, Nanos{0}, budget);
  place.pacing.phase.reset();
  place.pacing.after = plan::After{leader, every};
  return place;
}

inline policy::SubchainPlace shares(int core) {
  policy::SubchainPlace place;
  place.core = core;
  place.cpus = os::CpuSet{core};
  return place;
}

inline policy::Assignment assignment(std::vector<policy::SubchainPlace> places,
                                     std::vector<dispatch::SharedCoreSchedule> cores = {}) {
  policy::Assignment assignment;
  assignment.places = std::move(places);
  assignment.cores = std::move(cores);
  return assignment;
}

// The same for all runs.
inline FakeWorld::Cost each_takes(Nanos cost) {
  return [cost](SubchainId, std::uint64_t) { return cost; };
}

}  // namespace ctn::driver
