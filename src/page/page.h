// One run, or two side by side, as a page: what ran, the app as a graph, timelines of cores, response and compute times
// over time and as distributions, predicted beside measured. One HTML file with its script inside, which loads
// nothing else.
//
//   auto story = page::tell(record);
//   file << page::to_html({"run.catan", *story});
//
// How: figures and static pictures (plots.h) are in the page as they are; the script (script/) draws the timelines from
// data that is embedded (data.h), with as much of it in full detail as the page's size allows (detail.h).
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>

#include "base/result.h"
#include "page/story.h"

namespace ctn::page {

constexpr std::size_t kMaxBytes = 20'000'000;

struct ShownRun {
  std::string name;  // of the record, as readers know it
  const Story& story;
};

// `max_bytes`: the page is no larger; detail is left out to that end, and the page says so.
std::string to_html(const ShownRun& run, std::size_t max_bytes = kMaxBytes);

// Compares what both apps have, by name, and names what only one has. kCaller: they have no node in common.
Result<std::string> compare_html(const ShownRun& run, const ShownRun& other, std::size_t max_bytes = kMaxBytes);

// The app's graph, and which subchain used which core over the run, as pictures without a script, for the beginning of
// another page. `head` belongs into that page's head.
struct Glance {
  std::string head;
  std::string body;
};
Glance glance(const ShownRun& run);

// Writes a page to a file, whole or not at all. kCaller: it is a record, which can only be named by a slip of the
// command line; another program writes it.
// kEnvironment: it cannot be written.
Status save(const std::string& html, const std::string& file);

}  // namespace ctn::page
