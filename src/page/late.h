// What made the longest responses of a chain long, as HTML: each response is a bar of its parts, with its cause, all on
// one scale; opened, it shows the sums of its parts beside what is usual of them. It needs no script, and works by
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
  why::Part part;  // one of the parts that it stands for
  std::size_t columns = 0;
};

// The bar of a response, of at most so many columns; parts that are longest in none of them are left out. Never empty.
std::vector<Stretch> bar_of(const why::Response& response, std::size_t columns);

// Adds how many responses of the chain were late by which causes, and its longest responses. Adds nothing if none was
// measured.
void add_late(report::Page& page, const Story& story, std::size_t chain);

}  // namespace ctn::page
