// Any bytes as an app file: an app or errors that say where, never a crash or a hang.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/app_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto app = ctn::config::parse_app({reinterpret_cast<const char*>(data), size}, "fuzz.yaml");
  if (app.ok()) {
    for (const auto& term : app->objective) {
      if (app->graph.chain_elements(term.path).empty()) std::abort();
    }
    return 0;
  }
  for (const auto& problem : app.error().problems()) {
    if (problem.place.line < 1 || problem.place.column < 1 || problem.what.empty() || problem.hint.empty())
      std::abort();
  }
  return 0;
}
