// Whatever plans follow each other, however long runs take, and whichever subchains come and go: at any time one
// controller holds a subchain or none does, no trigger is lost and none is sent twice (testing/fake_world.h looks at
// that), and those that are present go on being triggered.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "driver/testing/samples.h"

namespace ctn::driver {
namespace {

constexpr std::size_t kSubchains = 4;
constexpr std::size_t kCores = 2;

// How it is paced where it takes turns with no other: it owns its CPU, or has a fixed priority.
policy::SubchainPlace arbitrary_pacing(std::size_t index) {
  const os::CpuSet own{static_cast<int>(kCores + index)};
  const Nanos period = ms(*rc::gen::inRange(1, 20));
  const int form = *rc::gen::inRange(0, 3);
  if (form == 0) return paced(period, own, ms(100));
  const int rank = static_cast<int>(index);
  const Nanos budget = std::chrono::microseconds{
      *rc::gen::weightedOneOf<int>({{1, rc::gen::just(0)}, {2, rc::gen::inRange(100, 15000)}})};
  policy::SubchainPlace place = phased(rank, period, period * *rc::gen::inRange(0, 10) / 10, budget);
  if (form == 2) {
    // Of any other, which may be absent, or follow it in turn: then both are triggered as silent ones are.
    const SubchainId leader((index + static_cast<std::size_t>(*rc::gen::inRange(1, static_cast<int>(kSubchains)))) %
                            kSubchains);
    place = follows(rank, leader, *rc::gen::inRange(1, 4), period, budget);
  }
  place.pacing.hang_after = ms(100);
  place.cpus = own;
  return place;
}

// Each has its CPU to itself, has a fixed priority, or shares one of the cores.
policy::Assignment arbitrary_assignment() {
  policy::Assignment made;
  made.cores.resize(kCores);
  std::vector<bool> present;
  for (std::size_t index = 0; index < kSubchains; ++index) {
    const int core = *rc::gen::inRange(-1, static_cast<int>(kCores));
    present.push_back(*rc::gen::weightedElement<bool>({{5, true}, {1, false}}));
    if (core < 0) {
      made.places.push_back(arbitrary_pacing(index));
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
    const bool stealing = *rc::gen::arbitrary<bool>();
    for (dispatch::SharedCoreSlot& slot : core.slots) slot.may_steal = stealing;
  }
  policy::remove_absent(made, present);
  return made;
}

// On a shared core, by a subchain of a higher rank.
bool may_be_stolen_from(const policy::Assignment& assignment, SubchainId victim) {
  const int core = assignment.places[victim.index()].core;
  if (core < 0) return false;
  const std::vector<dispatch::SharedCoreSlot>& slots = assignment.cores[static_cast<std::size_t>(core)].slots;
  const auto own = std::find_if(slots.begin(), slots.end(), [&](const auto& slot) { return slot.subchain == victim; });
  return own != slots.end() && std::any_of(slots.begin(), slots.end(), [&](const dispatch::SharedCoreSlot& slot) {
           return slot.may_steal && slot.rank < own->rank;
         });
}

RC_GTEST_PROP(HandOver, LosesNoTriggerAndSendsNoneTwice, ()) {
  const auto costs = *rc::gen::container<std::vector<int>>(7, rc::gen::inRange(0, 15000));
  FakeWorld world(kSubchains, kCores, [&](SubchainId id, std::uint64_t number) {
    return std::chrono::microseconds{costs[(number + id.index()) % costs.size()]};
  });
  // No output now and then, and more runs at a time than one: never.
  world.gives_output = [](SubchainId id, std::uint64_t number) { return (number + id.index()) % 5 != 0; };
  world.after_step = [&] {
    for (const FakeWorld::Subchain& subchain : world.subchains) {
      RC_ASSERT(subchain.triggers.size() <= subchain.completed + 1);
    }
  };
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
  // Longer than any leader is silent.
  world.run_for(ms(1200));
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
    // Runs that never fit their slices may steal all slots of those below them, which a plan would not ask for.
    if (!may_be_stolen_from(last, SubchainId(index))) RC_ASSERT(subchain.triggers.size() > before[index]);
    if (place.pacing.phase) {
      for (std::size_t k = before[index] + 1; k < subchain.triggers.size(); ++k) {
        RC_ASSERT((subchain.triggers[k].due.time_since_epoch() - *place.pacing.phase) % place.pacing.period ==
                  Nanos{0});
      }
    }
    // One at the level of demoted runs was demoted since its last trigger.
    const bool demoted = place.core < 0 && subchain.levels.front() == os::Level::kBackground;
    const bool told = std::any_of(world.overruns.begin(), world.overruns.end(), [&](const dispatch::Overrun& overrun) {
      return overrun.subchain == SubchainId(index) && overrun.number == subchain.triggers.size();
    });
    RC_ASSERT(!demoted || told);
  }
  // No controller is woken by outputs that it does not follow.
  for (std::size_t leader = 0; leader < kSubchains; ++leader) {
    for (const std::size_t subscriber : world.subchains[leader].subscribers) {
      RC_ASSERT(subscriber < kSubchains && last.places[subscriber].pacing.after);
      RC_ASSERT(last.places[subscriber].pacing.after->leader == plan::Leader(SubchainId(leader)));
    }
  }
  RC_ASSERT(!testing::Test::HasFailure());
}

}  // namespace
}  // namespace ctn::driver
