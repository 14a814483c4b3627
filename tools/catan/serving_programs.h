// Serving an app to programs that are started for it, and showing what came of it: what `catan run` and `catan ros run`
// share.
//
// Thread safety: one thread.
#pragma once

#include <functional>
#include <string>

#include "base/result.h"
#include "config/app_file.h"
#include "scheduling_options.h"
#include "serving.h"
#include "watch.h"

namespace ctn::tool {

// `serving` says which programs, where the server listens, and for how long; the scheduler, notices and the status line
// are set here. `remark` goes into the record; `look`, if given, is called twice a second.
Result<Served> serve_programs(const config::AppFile& file, const SchedulingOptions& scheduling,
                              const WatchedApp& watched, const std::string& record_path, ServingOptions serving,
                              std::string remark, const std::function<void(const Snapshot&)>& look = {});

// Prints the report of its record. The command's exit code.
int show_served(const Served& served, const std::string& record_path, bool json);

}  // namespace ctn::tool
