// Command lines of an app's program, for the tests of its options.
#pragma once

#include <initializer_list>
#include <variant>
#include <vector>

#include "program/leave.h"

namespace ctn::program::testing {

// What `parse_options(argc, argv)` makes of the words behind the program's name.
template <class ParseOptions>
auto parsed(const char* program, std::initializer_list<const char*> words, const ParseOptions& parse_options) {
  std::vector<const char*> argv = {program};
  argv.insert(argv.end(), words);
  return parse_options(static_cast<int>(argv.size()), argv.data());
}

// The exit code; -1: the program goes on.
template <class Options>
int code_of(const std::variant<Options, Leave>& parsed) {
  return std::holds_alternative<Leave>(parsed) ? std::get<Leave>(parsed).code : -1;
}

}  // namespace ctn::program::testing
