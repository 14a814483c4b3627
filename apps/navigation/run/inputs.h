// What a run depends on beside its options: the contents of the files that these name (program/inputs.h).
//
// Thread safety: pure, but for what is read.
#pragma once

#include <map>
#include <string>

#include "run/detector_chain.h"
#include "run/options.h"

namespace ctn::navigation::run {

// By name ("app", "world", "image", "costs", "detector") a fingerprint of what it holds. "image": that the world names,
// if it does. A crowd has no world file: it follows from the seed. Files that cannot be read are left out: whoever
// opens them says so. `detector` may be null.
std::map<std::string, std::string> inputs_of(const Options& options, const DetectorChain* detector);

}  // namespace ctn::navigation::run
