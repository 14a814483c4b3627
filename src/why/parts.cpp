#include "why/parts.h"

#include <string_view>

namespace ctn::why {

const char* to_string(PartKind kind) {
  constexpr std::array<std::string_view, kPartKinds> kNames{"waiting-for-sample",
                                                            "waiting-for-trigger",
                                                            "late-trigger",
                                                            "late-timer",
                                                            "own-previous-run",
                                                            "plan-change",
                                                            "no-output",
                                                            "waiting-for-slot",
                                                            "stolen",
                                                            "pre-empted",
                                                            "kernel",
                                                            "running",
                                                            "running-longer",
                                                            "device",
                                                            "waiting-for-tick",
                                                            "unexplained"};
  return kNames[static_cast<std::size_t>(kind)].data();
}

const char* to_string(CauseKind kind) {
  constexpr std::array<std::string_view, kCauseKinds> kNames{
      "long-run",   "pre-empted",         "waited-for-slot",   "stolen",          "late-trigger",
      "late-timer", "waited-for-trigger", "waited-for-sample", "waited-for-tick", "own-previous-run",
      "device",     "no-output",          "plan-change",       "starved",         "unexplained"};
  return kNames[static_cast<std::size_t>(kind)].data();
}

}  // namespace ctn::why
