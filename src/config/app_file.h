// The app file (docs/app-file.md): YAML text -> App. Strict: an unknown or doubled key, a missing unit, a dangling
// name, a cycle are errors, each with file:line:column, the key, and what would be right; all of them at once.
//
// Nodes that are bound to messages of ROS need input (graph::Node::needs_input), as they do where ROS programs run
// them.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "graph/app.h"

namespace ctn::config {

// `file` names the text in errors. Never throws, whatever the text; kinds: kCaller.
Result<graph::App> parse_app(std::string_view text, std::string_view file);

// Reads and parses. A file that is not there or cannot be read is kCaller too: the caller named it.
Result<graph::App> load_app(const std::string& path);

// The same for callers that pass the text on, too: `app` is made of this text, even if the file changes later.
struct AppFile {
  std::string text;
  graph::App app;
};
Result<AppFile> load_app_file(const std::string& path);

// Whole text of a file, at most 1 MiB. kCaller.
Result<std::string> read_text(const std::string& path);

}  // namespace ctn::config
