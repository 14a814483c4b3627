// Whatever plans follow each other, however long runs take, and whoever comes and goes: at any time one controller
// holds a subchain or none does, no trigger is lost and none is sent twice (testing/fake_world.h looks at that), and
// whoever is present goes on being triggered.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "driver/testing/samples.h"

namespace ctn::driver {
namespace {

constexpr std::size_t kSubchains = 4;
constexpr std::size_t kCores = 2;

// Each has its CPU to itself or shares one of the cores.
policy::Assignment arbitrary_assignment() {
  policy::Assignment made;
  made.cores.resize(kCores);
  std::vector<bool> present;
  for (std::size_t index = 0; index < kSubchains; ++index) {
    const int core = *rc::gen::inRange(-1, static_cast<int>(kCores));
    present.push_back(*rc::gen::weightedElement<bool>({{5, true}, {1, false}}));
    if (core < 0) {
      made.places.push_back(paced(ms(*rc::gen::inRange(1, 20)), os::CpuSet{static_cast<int>(kCores + index)}, ms(100)));
    } else {
      made.places.push_back(shares(core));
      dispatch::SharedCoreSlot slot =
          every(*rc::gen::inRange(1, 4), static_cast<int>(index), ms(*rc::gen::inRange(1, 6)));
      slot.hang_after = ms(100);
      made.cores[static_cast<std::size_t>(core)].slots.push_back(slot);
    }
  }
  for (dispatch::SharedCoreSchedule& core : made.cores) {
    core.frame_min = ms(*rc::gen::inRange(1, 10));
    core.slack = *rc::gen::element(0.0, 0.1);
  }
  policy::remove_absent(made, present);
  return made;
}

RC_GTEST_PROP(HandOver, LosesNoTriggerAndSendsNoneTwice, ()) {
  const auto costs = *rc::gen::container<std::vector<int>>(7, rc::gen::inRange(0, 15000));
  FakeWorld world(kSubchains, kCores, [&](SubchainId id, std::uint64_t number) {
    return std::chrono::microseconds{costs[(number + id.index()) % costs.size()]};
  });
  const int plans = *rc::gen::inRange(1, 12);
  policy::Assignment last;
  for (int plan = 0; plan < plans; ++plan) {
    last = arbitrary_assignment();
    world.publish(last);
    world.run_for(std::chrono::microseconds{*rc::gen::inRange(0, 30000)});
  }
  world.run_for(ms(200));
  std::vector<std::size_t> before;
  for (const FakeWorld::Subchain& subchain : world.subchains) before.push_back(subchain.triggers.size());
  world.run_for(ms(300));
  for (std::size_t index = 0; index < kSubchains; ++index) {
    const policy::SubchainPlace& place = last.places[index];
    const FakeWorld::Subchain& subchain = world.subchains[index];
    RC_ASSERT(subchain.holder.has_value() == place.present);
    if (!place.present) {
      RC_ASSERT(subchain.triggers.size() == before[index]);
      continue;
    }
    RC_ASSERT(*subchain.holder == (place.core < 0 ? index : kSubchains + static_cast<std::size_t>(place.core)));
    RC_ASSERT(subchain.cpus == place.cpus);
    RC_ASSERT(subchain.triggers.size() > before[index]);
  }
  RC_ASSERT(!testing::Test::HasFailure());
}

}  // namespace
}  // namespace ctn::driver
