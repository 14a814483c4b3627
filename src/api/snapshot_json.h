// A snapshot as the C ABI and `catan ctl status` give it: one JSON object, the names those of include/catan/snapshot.h.
#pragma once

#include <string>

#include "catan/snapshot.h"

namespace ctn::api {

std::string to_json(const Snapshot& snapshot);

}  // namespace ctn::api
