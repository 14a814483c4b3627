// Weights and bounds that were changed while an app ran: what differs between two states of it, and the app after that.
//
// Units: as events.h says. Thread safety: pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/events.h"

namespace ctn::record {

// The words of the record.
const char* to_string(AppChange::What what);
std::optional<AppChange::What> change_named(std::string_view what);

// What is different in `after`, which is `before` with other weights and bounds.
std::vector<AppChange> differences(const graph::App& before, const graph::App& after, TimePoint at);
// The app with these changes, which were made to it in this order. kCaller: such a change is none of this app.
Result<graph::App> app_after(const graph::App& app, std::span<const AppChange> changes);
// For people: "objective[0].weight (scan -> LM): 1 -> 0.5".
std::string describe(const graph::App& app, const AppChange& change);

}  // namespace ctn::record
