// Where the maps of the navigation studies are.
//
// Thread safety: pure, but for looking which files are there.
#pragma once

#include <string>

namespace ctn::case_studies {

// The file of `--map MAP` of the navigation program: map 1 and 2 are beside it, or where both were installed to.
std::string file_of_map(const std::string& map, const std::string& program);

}  // namespace ctn::case_studies
