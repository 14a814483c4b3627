// One run, or two side by side, as a page: what ran, the app as a graph, timelines of cores, response and compute times
// over time and as distributions, predicted beside measured. One file of HTML with its script inside; nothing is
// fetched.
//
//   auto story = page::tell(record);
//   file << page::to_html({"run.catan", *story});
//
// How: figures and static pictures (plots.h) are in the page as they are; the script (script/) draws the timelines from
// data that is embedded (data.h), as much of it in full detail as the page may have bytes (detail.h).
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <string>

#include "base/result.h"
#include "page/story.h"

namespace ctn::page {

constexpr std::size_t kMostBytes = 20'000'000;

struct Told {
  std::string name;  // of the record, for people
  const Story& story;
};

// `most_bytes`: the page is no larger, for which detail is left out, and said to be.
std::string to_html(const Told& run, std::size_t most_bytes = kMostBytes);

// What both apps have is compared, by name, and what only one has is named. kCaller: they have no node in common.
Result<std::string> compare_html(const Told& run, const Told& other, std::size_t most_bytes = kMostBytes);

// What the page of something else may begin with: the app's graph, and who used which core over the run; pictures
// without a script. `head` belongs into that page's head.
struct Glance {
  std::string head;
  std::string body;
};
Glance glance(const Told& run);

// Writes a page to a file. A record is not written over (kCaller): it is there by a slip of the command line.
// kEnvironment: the file cannot be written.
Status save(const std::string& html, const std::string& file);

}  // namespace ctn::page
