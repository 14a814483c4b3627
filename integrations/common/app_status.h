// What a framework's own tools are told of the app (shown_app.h), made of Catan's JSON documents: `live`, what the app
// does at present (docs/top.md), and `status`, what is asked of it (`catan ctl status --json`). A document of another
// shape makes these functions throw nlohmann::json::exception.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "catan/changes.h"
#include "common/shown_app.h"

namespace catan_ros {

// Of the app, the plan in force, and all chains, subchains and nodes. What is wrong:
//   app       an error if it does not live; a warning if real-time levels are not set
//   plan      a warning if it relaxes bounds, or had to assume what a node costs
//   chain     a warning if responses of the last seconds were over their bound, or, without one, over what was promised
//   subchain  a warning if runs were demoted, since they used more than their budget
//   node      an error if it has never run, or not for ten of its periods, and for a second at least
std::vector<Diagnostic> diagnostics_of(const nlohmann::json& live);

// There is no such app at present.
Diagnostic diagnostic_of_no_app(const std::string& why);

std::vector<ResponseTime> response_times_of(const nlohmann::json& live);
std::vector<Setting> settings_of(const nlohmann::json& status);

// What has to be asked for, so that settings have these values, by their names. Settings that have them already are
// left out. `unknown`: the names that no setting has.
ctn::Changes changes_to(const std::vector<Setting>& settings, const std::vector<std::pair<std::string, double>>& values,
                        std::vector<std::string>& unknown);

}  // namespace catan_ros
