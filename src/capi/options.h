// Options from programs that were built with another version of the header, older or newer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace ctn::capi {

// What the caller gave, the rest as in `defaults`. `given` may be null. Options begin with their own size.
template <class Options>
Options with_defaults(const Options* given, Options defaults) {
  if (given == nullptr) return defaults;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  std::memcpy(static_cast<void*>(&defaults), given, std::min(size, sizeof defaults));
  return defaults;
}

}  // namespace ctn::capi
