// Options from programs that were built with another version of the header, older or newer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

#include "base/result.h"

namespace ctn::capi {

// What the caller gave, the rest as in `defaults`, which `macro` names. `given` may be null. Options begin with their
// own size; no version's is less than `least`. kCaller: it is, as where the caller began with zeros.
template <class Options>
Result<Options> with_defaults(const Options* given, Options defaults, std::size_t least, const char* macro) {
  if (given == nullptr) return defaults;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  if (size < least) {
    return Error::caller("the options' `size` is " + std::to_string(size) + ", which is that of no version",
                         std::string("begin with ") + macro);
  }
  std::memcpy(static_cast<void*>(&defaults), given, std::min(size, sizeof defaults));
  return defaults;
}

}  // namespace ctn::capi
