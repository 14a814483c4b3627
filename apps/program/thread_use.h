// What a thread of a program's own, which stands for hardware, took in real time.
//
// Thread safety: a value.
#pragma once

#include <cstdint>

namespace ctn::program {

struct ThreadUse {
  double cpu_share = 0.0;    // of one CPU
  double late_ms_max = 0.0;  // of what it told the nodes
  std::uint64_t lost = 0;    // of what nodes did (exchange.h): neither it nor the figures know anything of that
};

}  // namespace ctn::program
