// For benchmarks: what a call must give, or the benchmark ends with what went wrong.
#pragma once

#include <stdexcept>
#include <utility>

#include "base/result.h"

namespace ctn::bench {

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

}  // namespace ctn::bench
