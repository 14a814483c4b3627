// What many samples of one metric come to. A percentile is the smallest sample such that at least so many percent of
// all are no larger. Plain values.
#pragma once

#include <cstdint>

namespace ctn {

struct Summary {
  std::uint64_t count = 0;  // 0: all else is 0 too
  double mean = 0.0;
  double p50 = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

}  // namespace ctn
