// Command lines of an app's program, for the tests of its options.
#pragma once

#include <initializer_list>
#include <string>
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

// Whether the program shows its help, and that has examples.
template <class Options>
bool shows_examples(const std::variant<Options, Leave>& parsed) {
  const auto* const leave = std::get_if<Leave>(&parsed);
  return leave != nullptr && leave->code == 0 && leave->text.find("examples:") != std::string::npos;
}

}  // namespace ctn::program::testing
