// What all exports have in common: where they write to, and how they report progress.
#pragma once

#include <functional>
#include <string_view>

#include "base/result.h"

namespace ctn::exports {

// Takes the next bytes; after its first failure it is not called again.
using Sink = std::function<Status(std::string_view)>;

// Called from time to time with the part that is done, from 0 to 1.
using Progress = std::function<void(double)>;

}  // namespace ctn::exports
