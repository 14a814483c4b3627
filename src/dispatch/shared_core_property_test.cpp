// What a shared core promises, whatever the schedule, the costs and the timers. VirtualCore itself throws where two
// subchains are active at once, a trigger is sent while a run is under way, or the dispatcher asks for the present
// again and again; so each property checks these too.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "dispatch/shared_core_dispatcher.h"
#include "dispatch/testing/shared_core_samples.h"
#include "dispatch/testing/virtual_core.h"

namespace ctn::dispatch {
namespace {

using std::chrono::microseconds;

constexpr TimePoint kEnd = at(std::chrono::milliseconds{600});

int number(int min, int below) { return *rc::gen::inRange(min, below); }
bool chance(int percent) { return number(0, 100) < percent; }

SharedCoreSlot arbitrary_slot(int subchain, Nanos shortest) {
  const Nanos slice = shortest + microseconds{number(0, 4000)};
  if (chance(30)) return queue(number(1, 30) * 0.1, subchain, slice);
  const int n = number(1, 5);
  return every(n, subchain, slice, number(0, n));
}

// Of these subchains, in some order of slots; ranks follow another.
SharedCoreSchedule arbitrary_schedule(std::vector<int> subchains, Nanos shortest = Nanos{0}) {
  std::vector<SharedCoreSlot> slots;
  for (const int subchain : subchains) {
    const auto before = static_cast<std::ptrdiff_t>(number(0, static_cast<int>(slots.size()) + 1));
    slots.insert(slots.begin() + before, arbitrary_slot(subchain, shortest));
    slots[static_cast<std::size_t>(before)].may_steal = chance(70);
    if (chance(40)) slots[static_cast<std::size_t>(before)].hang_after = microseconds{number(1, 100000)};
  }
  std::vector<int> ranks(slots.size());
  std::iota(ranks.begin(), ranks.end(), 0);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    std::swap(ranks[i], ranks[static_cast<std::size_t>(number(static_cast<int>(i), static_cast<int>(slots.size())))]);
    slots[i].rank = ranks[i];
  }
  const double slack = number(0, 4) * 0.1;
  if (chance(60)) return elastic(slots, slack, chance(50) ? Nanos{0} : Nanos{microseconds{number(0, 20000)}});
  Nanos used = microseconds{number(1, 5000)};
  for (const SharedCoreSlot& slot : slots) used += slot.slice;
  return fixed(slots, to_nanos(to_millis(used) / (1.0 - slack)), slack);
}

std::vector<int> some_subchains() {
  std::vector<int> subchains(static_cast<std::size_t>(number(1, 5)));
  std::iota(subchains.begin(), subchains.end(), 0);
  return subchains;
}

// Runs from nothing to `max`, and a spike now and then.
VirtualCore::Cost arbitrary_costs(Nanos max, int spikes_percent) {
  std::vector<Nanos> drawn;
  for (int i = 0; i < 16; ++i) drawn.push_back(chance(spikes_percent) ? 20 * max : max * number(0, 101) / 100);
  return [drawn](SubchainId subchain, std::uint64_t run) { return drawn[(run * 7 + subchain.index() * 5) % 16]; };
}

VirtualCore::Lateness arbitrary_lateness() {
  if (chance(50)) return {};
  std::vector<Nanos> drawn;
  for (int i = 0; i < 8; ++i) drawn.emplace_back(microseconds{chance(80) ? number(0, 60) : number(0, 30000)});
  return [drawn](std::uint64_t call) { return drawn[call % 8]; };
}

const SharedCoreSlot& slot_of(const SharedCoreSchedule& schedule, SubchainId subchain) {
  return *std::find_if(schedule.slots.begin(), schedule.slots.end(),
                       [&](const SharedCoreSlot& slot) { return slot.subchain == subchain; });
}

Nanos sum_of_slices(const SharedCoreSchedule& schedule) {
  Nanos sum{0};
  for (const SharedCoreSlot& slot : schedule.slots) sum += slot.slice;
  return sum;
}

// How long a frame can be where no subchain is late: T.
Nanos longest_frame(const SharedCoreSchedule& schedule) {
  if (schedule.frames == graph::FrameMode::kFixed) return std::max(schedule.frame, kShortestFrame);
  const Nanos busy = to_nanos(to_millis(sum_of_slices(schedule)) / (1.0 - schedule.slack));
  return std::max({busy + Nanos{1}, schedule.frame_min, kShortestFrame});
}

RC_GTEST_PROP(SharedCoreProperty, KeepsItsWordWhateverHappens, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains());
  auto core = VirtualCore::with_all(schedule, arbitrary_costs(ms(8), 10), arbitrary_lateness());
  core.run_until(kEnd);
  for (const auto& [subchain, triggers] : core.triggers) {
    for (std::size_t k = 1; k < triggers.size(); ++k) RC_ASSERT(triggers[k].due >= triggers[k - 1].due);
  }
  for (std::size_t k = 1; k < core.frames.size(); ++k) {
    RC_ASSERT(core.frames[k] > core.frames[k - 1]);
    if (schedule.frames == graph::FrameMode::kElastic) {
      RC_ASSERT(core.frames[k] - core.frames[k - 1] >= std::max(schedule.frame_min, kShortestFrame));
    }
  }
}

RC_GTEST_PROP(SharedCoreProperty, IsDeterministic, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains());
  const VirtualCore::Cost cost = arbitrary_costs(ms(8), 10);
  const VirtualCore::Lateness lateness = arbitrary_lateness();
  auto one = VirtualCore::with_all(schedule, cost, lateness);
  auto other = VirtualCore::with_all(schedule, cost, lateness);
  one.run_until(kEnd);
  other.run_until(kEnd);
  RC_ASSERT(one.trace() == other.trace());
  RC_ASSERT(one.triggers == other.triggers);
}

// Where no run costs more than planned, no period is longer than planned: p = T / f, and no subchain has to steal.
RC_GTEST_PROP(SharedCoreProperty, EveryRateIsAtLeastThePlannedOne, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains(), microseconds{100});
  const int percent = number(0, 101);
  const auto cost = [&](SubchainId subchain, std::uint64_t run) {
    const SharedCoreSlot& slot = slot_of(schedule, subchain);
    const auto planned = static_cast<std::int64_t>(static_cast<double>(slot.slice.count()) / slot.share * (1 - 1e-9));
    return Nanos{planned * (run % 3 == 0 ? 100 : percent) / 100};
  };
  auto core = VirtualCore::with_all(schedule, cost);
  const Nanos frame = longest_frame(schedule);
  constexpr int kFrames = 60;
  core.run_until(at(frame * kFrames + 2 * kSmallestSlack));
  for (const SharedCoreSlot& slot : schedule.slots) {
    if (slot.slice / microseconds{1} == 0) continue;
    // The first trigger may wait for its phase, and the last run may be under way.
    const double planned = kFrames * slot.share - (slot.every ? 2.0 : 3.0) - slot.share;
    RC_ASSERT(static_cast<double>(core.completions[slot.subchain].size()) >= planned);
  }
  RC_ASSERT(core.steals.empty());
}

// A member that always has work gets its slice of each frame, but for what is stolen.
RC_GTEST_PROP(SharedCoreProperty, WhoHasWorkHasItsSliceInEveryFrame, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains());
  const SubchainId hog(static_cast<std::size_t>(number(0, static_cast<int>(schedule.slots.size()))));
  const VirtualCore::Cost others = arbitrary_costs(ms(6), 10);
  const VirtualCore::Cost cost = [&](SubchainId subchain, std::uint64_t run) {
    return subchain == hog ? Nanos{std::chrono::hours{1}} : others(subchain, run);
  };
  // Late timers cost time, but in elastic frames no subchain its slice.
  const bool late = schedule.frames == graph::FrameMode::kElastic && chance(30);
  auto core = VirtualCore::with_all(schedule, cost, late ? arbitrary_lateness() : VirtualCore::Lateness{});
  core.run_until(kEnd);
  RC_PRE(!core.triggers[hog].empty());
  const TimePoint begin = core.triggers[hog].front().sent;
  const auto first = std::lower_bound(core.frames.begin(), core.frames.end(), begin);
  RC_PRE(core.frames.end() - first >= 3);
  const auto frames = core.frames.end() - first - 1;
  Nanos stolen{0};
  for (const auto& steal : core.steals) {
    if (steal.victim == hog && steal.begin >= *first) stolen += steal.end - steal.begin;
  }
  const Nanos had = core.cpu_time(hog, *first, core.frames.back(), MemberLevel::kActive);
  RC_ASSERT(had + stolen >= slot_of(schedule, hog).slice * frames);
  if (!late) RC_ASSERT(core.frames.back() - *first <= longest_frame(schedule) * frames + kSmallestSlack);
}

RC_GTEST_PROP(SharedCoreProperty, OrdinaryThreadsHaveTheSlackOverAnyRowOfFrames, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains());
  const bool is_fixed = schedule.frames == graph::FrameMode::kFixed;
  auto core = VirtualCore::with_all(schedule, arbitrary_costs(ms(8), 30),
                                    is_fixed ? VirtualCore::Lateness{} : arbitrary_lateness());
  core.run_until(kEnd);
  // Elastic: what may still be owed at the end, and rounding. Fixed: nothing but rounding.
  for (std::size_t first = 0; first < core.frames.size(); first += 1 + core.frames.size() / 20) {
    for (std::size_t last = first; last < core.frames.size(); last += 1 + core.frames.size() / 20) {
      const Nanos all = core.frames[last] - core.frames[first];
      const Nanos tolerance = Nanos{last - first} + (is_fixed ? Nanos{0} : kSmallestSlack);
      const Nanos given = core.ordinary_time(core.frames[first], core.frames[last]);
      RC_ASSERT(to_millis(given + tolerance) >= to_millis(all) * schedule.slack);
    }
  }
}

RC_GTEST_PROP(SharedCoreProperty, NobodyStealsFromAHigherRankNorForLongerThanASlot, ()) {
  const SharedCoreSchedule schedule = arbitrary_schedule(some_subchains());
  auto core = VirtualCore::with_all(schedule, arbitrary_costs(ms(8), 30), arbitrary_lateness());
  core.run_until(kEnd);
  for (const auto& steal : core.steals) {
    const SharedCoreSlot& thief = slot_of(schedule, steal.thief);
    RC_ASSERT(thief.may_steal);
    RC_ASSERT(thief.rank < slot_of(schedule, steal.victim).rank);
    RC_ASSERT(steal.begin <= steal.end);
  }
  // Active in one's own slot, in one stolen, or not at all.
  struct Turns {
    std::vector<std::pair<TimePoint, TimePoint>> all;  // begins and ends
    std::size_t next = 0;                              // the first that is not over yet
  };
  std::map<SubchainId, Turns> allowed;
  for (const auto& slot : core.slots) allowed[slot.subchain].all.emplace_back(slot.begin, slot.end);
  for (const auto& steal : core.steals) allowed[steal.thief].all.emplace_back(steal.begin, steal.end);
  for (auto& [subchain, turns] : allowed) std::sort(turns.all.begin(), turns.all.end());
  for (const VirtualCore::Ran& ran : core.trace()) {
    if (ran.level != MemberLevel::kActive || ran.end > core.frames.back())
      continue;  // slots that are not over are not told
    Turns& turns = allowed[*ran.subchain];
    while (turns.next < turns.all.size() && turns.all[turns.next].second <= ran.begin) ++turns.next;
    Nanos time{0};
    for (std::size_t i = turns.next; i < turns.all.size() && turns.all[i].first < ran.end; ++i) {
      time += std::min(turns.all[i].second, ran.end) - std::max(turns.all[i].first, ran.begin);
    }
    RC_ASSERT(time == ran.end - ran.begin);
  }
}

// Subchains move between two cores and schedules change all the time; each run ends, is counted once, and its subchain
// is triggered again.
RC_GTEST_PROP(SharedCoreProperty, SwapsLoseNoRun, ()) {
  const std::vector<int> all{0, 1, 2, 3};
  std::vector<std::vector<int>> members{all, {}};
  const VirtualCore::Cost cost = arbitrary_costs(ms(2), 5);
  // Members that are stolen from, or whose slots are missed, may get nothing for long.
  const bool undisturbed = chance(50);
  const VirtualCore::Lateness lateness = undisturbed ? VirtualCore::Lateness{} : arbitrary_lateness();
  const auto schedule_of = [&](const std::vector<int>& subchains) {
    const SharedCoreSchedule schedule = arbitrary_schedule(subchains, microseconds{500});
    return undisturbed ? without_stealing(schedule) : schedule;
  };
  std::vector<VirtualCore> cores;
  cores.push_back(VirtualCore::with_all(schedule_of(all), cost, lateness));
  cores.emplace_back(SharedCoreSchedule{}, cost, lateness);
  const auto exchange = [&](TimePoint until) {
    for (VirtualCore& core : cores) core.run_until(until);
    for (VirtualCore& core : cores) {
      for (const auto& [subchain, what] : std::exchange(core.handed_over, {})) {
        const auto index = static_cast<int>(subchain.index());
        const bool on_first = std::count(members[0].begin(), members[0].end(), index) > 0;
        cores[on_first ? 0 : 1].adopt(subchain, what.first, what.second);
      }
    }
  };
  TimePoint now{};
  for (int swaps = number(1, 10); swaps > 0; --swaps) {
    for (Nanos wait = microseconds{number(0, 30000)}; wait >= Nanos{0}; wait -= ms(1)) exchange(now += ms(1));
    members = {{}, {}};
    for (const int subchain : all) members[chance(50) ? 0 : 1].push_back(subchain);
    for (const std::size_t core : {0U, 1U}) cores[core].change_schedule(schedule_of(members[core]));
  }
  const auto completed = [&](SubchainId subchain) {
    return cores[0].completions[subchain].size() + cores[1].completions[subchain].size();
  };
  for (int i = 0; i < 300; ++i) exchange(now += ms(1));
  std::vector<std::size_t> before;
  for (const int subchain : all) before.push_back(completed(SubchainId(static_cast<std::size_t>(subchain))));
  for (int i = 0; i < 4000; ++i) exchange(now += ms(1));
  for (std::size_t subchain = 0; subchain < all.size(); ++subchain) {
    const SubchainId id(subchain);
    RC_ASSERT(cores[0].threads.count(id) + cores[1].threads.count(id) == 1U);
    const VirtualCore& home = cores[cores[0].threads.count(id) > 0 ? 0 : 1];
    const VirtualCore::Threads& threads = home.threads.at(id);
    RC_ASSERT(threads.completed == completed(id));
    RC_ASSERT(threads.sent - threads.completed <= 1U);
    if (undisturbed) RC_ASSERT(completed(id) > before[subchain]);
  }
}

}  // namespace
}  // namespace ctn::dispatch
