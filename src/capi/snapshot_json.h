// A snapshot as the C ABI gives it: one JSON object, the names those of include/catan/snapshot.h.
#pragma once

#include <string>

#include "catan/snapshot.h"

namespace ctn::capi {

std::string to_json(const Snapshot& snapshot);

}  // namespace ctn::capi
