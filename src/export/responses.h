// The response times of a record's chains, one by one.
#pragma once

#include <cstddef>
#include <functional>

#include "base/result.h"
#include "record/lineage.h"
#include "record/reader.h"

namespace ctn::exports {

// Calls `take_run` for each run, in the order of their ends, and `take` for each sample of a chain, after the run that
// completes it. Chains are counted among the response times of the objective.
Status each_response(const record::Reader& record, const std::function<void(const record::Run&)>& take_run,
                     const std::function<void(std::size_t chain, const record::ChainSample&)>& take);

}  // namespace ctn::exports
