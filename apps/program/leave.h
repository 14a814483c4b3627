// How a program leaves without having run.
//
// Thread safety: values.
#pragma once

#include <string>

namespace ctn::program {

constexpr int kFailure = 1;  // exit codes: it could not run
constexpr int kMistake = 2;  // a mistake on the command line or in a file

// What to do instead of running: print `text` (to stdout where `code` is 0) and leave with `code`.
struct Leave {
  int code = 0;
  std::string text;
};

}  // namespace ctn::program
