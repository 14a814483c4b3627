// Functions of a C program as the C++ API takes them. An exception that one throws ends the process: C cannot
// handle it.
#pragma once

#include <functional>
#include <string>

#include "catan/catan.h"
#include "catan/run.h"

namespace ctn::capi {

inline catan_run* handle_of(Run& run) { return reinterpret_cast<catan_run*>(&run); }
inline Run& run_of(catan_run* run) { return *reinterpret_cast<Run*>(run); }
inline const Run& run_of(const catan_run* run) { return *reinterpret_cast<const Run*>(run); }

// Empty where there is none, which start() complains about.
inline std::function<void(Run&)> body_of(catan_node_function function, void* user) {
  if (function == nullptr) return {};
  return [function, user](Run& run) noexcept { function(handle_of(run), user); };
}

inline std::function<void(const std::string&)> notice_of(catan_notice_function function, void* user) {
  if (function == nullptr) return {};
  return [function, user](const std::string& text) noexcept { function(text.c_str(), user); };
}

inline std::string text_of(const char* text) { return text == nullptr ? "" : text; }

}  // namespace ctn::capi
