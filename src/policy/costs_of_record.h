// What runs cost in a record, to plan with: by all of them, from the first to the last, whatever changed meanwhile. Who
// wants the costs of a part of a run records that part.
//
// Of nodes whose runs work on several threads the CPU time is taken to be that on one thread: a record does not say how
// many there were.
//
// Units: in the types. Thread safety: none; one owner.
#pragma once

#include "base/result.h"
#include "graph/app.h"
#include "policy/measured_costs.h"
#include "record/reader.h"

namespace ctn::policy {

// `app` outlives the result; its nodes are found by their names. Errors: the reader's; a scheduled node of the app that
// has no run in the record; other CPUs than the kinds of cores that the app lists (kCaller).
Result<MeasuredCosts> costs_of_record(const record::Reader& record, const graph::App& app);

}  // namespace ctn::policy
