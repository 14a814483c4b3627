// What made the longest responses of a chain long: each as a bar of its parts with the cause named, all on one scale;
// opened, the sums of its parts beside what is usual of them. HTML that needs no script, and can be reached with the
// keyboard.
//
// Thread safety: pure functions.
#pragma once

#include <cstddef>
#include <vector>

#include "page/story.h"
#include "report/html.h"

namespace ctn::page {

// A stretch of a bar: neighbouring columns in which the same part is longest.
struct Stretch {
  why::Part part;  // one of those that it stands for
  std::size_t columns = 0;
};

// A response in so many columns at most; parts that are longest in none are left out. Never empty.
std::vector<Stretch> bar_of(const why::Response& response, std::size_t columns);

// How many responses of the chain were late by which causes, and its longest ones. Nothing where none was measured.
void add_late(report::Page& page, const Story& story, std::size_t chain);

}  // namespace ctn::page
