// The app file (docs/app-file.md): YAML text -> App. Strict: an unknown or doubled key, a missing unit, a dangling
// name, a cycle are errors, each with file:line:column, the key, and what would be right; all of them at once.
//
// What the file says of programs counts only where these run the nodes, so whoever reads it says what does.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"

namespace ctn::config {

// What runs the nodes of the app.
// kBoundPrograms: the programs that the file binds to them, as it says. Nodes that are bound to messages of ROS need
//   input (graph::Node::needs_input), since callbacks are called for messages alone. Also for an app that is looked at
//   and not run. The default: to take a callback for a function means plans that cannot come true; to take a function
//   for a callback, only that it is planned to run no more often than there is something new.
// kFunctions: functions that Catan calls at each trigger, whatever has come: of a session or a simulation, or a
//   synthetic load. No node needs input.
enum class RunBy { kBoundPrograms, kFunctions };

// `file` names the text in errors. Never throws, whatever the text; kinds: kCaller.
Result<graph::App> parse_app(std::string_view text, std::string_view file, RunBy run_by = RunBy::kBoundPrograms);

// Reads and parses. A file that is not there or cannot be read is kCaller too: the caller named it.
Result<graph::App> load_app(const std::string& path, RunBy run_by = RunBy::kBoundPrograms);

// The same for callers that pass the text on, too: `app` is made of this text, even if the file changes later.
struct AppFile {
  std::string text;
  graph::App app;
};
Result<AppFile> load_app_file(const std::string& path, RunBy run_by = RunBy::kBoundPrograms);

// Whole text of a file, at most 1 MiB. kCaller.
Result<std::string> read_text(const std::string& path);

}  // namespace ctn::config
