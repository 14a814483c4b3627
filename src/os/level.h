// Real-time priorities as Catan knows them. Only os/linux knows what they are in Linux.
//
// Thread safety: plain values.
#pragma once

namespace ctn::os {

// Which thread pre-empts which: each level pre-empts all before it. kOrdinary is the system's fair scheduling, the rest
// is real-time.
enum class Level { kOrdinary, kBackground, kActive, kUnscheduled, kDispatcher };
const char* to_string(Level level);

// Beyond these there are fixed priorities, a level a rank: for policies that give parts of an app a priority of their
// own. Each pre-empts all levels above, the dispatcher's too. So where any of them is in use, controllers and
// nodes that run by themselves are at fixed levels beyond it (policy/levels.h): in a session they are raised before the
// first plan that needs it is followed, and stay there, since until all controllers follow the next plan, threads may
// be at any level of the one before. Background and active serve cores whose subchains take turns, and threads that
// were demoted. Precondition: 0 <= rank < kFixedLevels.
constexpr int kFixedLevels = 66;
constexpr Level fixed_level(int rank) { return static_cast<Level>(static_cast<int>(Level::kDispatcher) + 1 + rank); }
constexpr Level kHighestLevel = fixed_level(kFixedLevels - 1);

}  // namespace ctn::os
