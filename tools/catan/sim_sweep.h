// `catan sim --sweep FOLDER --out FILE`: simulates every app of a folder, on all CPUs, into one file that a stopped
// sweep goes on with.
//
// An app is NAME.yaml with NAME.costs.yaml next to it. FILE has one JSON document a line: first what was asked, then an
// app a line, by name: {"app": NAME, "result": ...} or {"app": NAME, "error": ...}. A line is written once all before
// it are, so the same sweep makes the same bytes, with any number of threads, stopped and gone on with or not. A last
// line that a stop cut short is dropped and done again.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "base/result.h"

namespace ctn::tool {

struct Sweep {
  std::string folder;
  std::string out;
  std::string asked;  // one line of JSON: whatever changes what comes out
  std::size_t threads = 0;
  // An app file and its cost file, to a JSON document. From several threads at once.
  std::function<Result<std::string>(const std::string& app, const std::string& costs)> simulate;
  // How many apps are done of how many, one call at a time.
  std::function<void(std::size_t, std::size_t)> on_progress;
};

struct Swept {
  std::size_t apps = 0;
  std::size_t found_done = 0;
  std::size_t failed = 0;  // among those done now
};

// Errors: a folder without apps, a file of another sweep (kCaller), one that cannot be written (kEnvironment).
Result<Swept> sweep(const Sweep& what);

}  // namespace ctn::tool
