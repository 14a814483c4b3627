// How Linux names its scheduling classes, for files that other programs read. Within Catan they are levels (level.h).
#pragma once

namespace ctn::os {

inline constexpr const char* kFixedPriorityClass = "SCHED_FIFO";
inline constexpr const char* kOrdinaryClass = "SCHED_OTHER";

}  // namespace ctn::os
