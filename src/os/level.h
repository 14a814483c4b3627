// Real-time priorities as Catan knows them. Only os/linux knows what they are in Linux.
//
// Thread safety: plain values.
#pragma once

namespace ctn::os {

// Who pre-empts whom: each level pre-empts all before it. kOrdinary is the system's fair scheduling, the rest is
// real-time.
enum class Level { kOrdinary, kBackground, kActive, kUnscheduled, kDispatcher };
const char* to_string(Level level);

// Beyond these there are fixed priorities, a level a rank: for policies that give each part of an app one priority
// permanently. Not to be used together with the levels above. Precondition: 0 <= rank < kFixedLevels.
constexpr int kFixedLevels = 66;
constexpr Level fixed_level(int rank) { return static_cast<Level>(static_cast<int>(Level::kDispatcher) + 1 + rank); }

}  // namespace ctn::os
