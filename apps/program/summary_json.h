// A metric as the apps' programs print it in JSON.
//
// Thread safety: pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include "catan/summary.h"

namespace ctn::program {

// Without samples all figures are null.
inline nlohmann::ordered_json json_of(const Summary& summary) {
  if (summary.count == 0) return {{"mean", nullptr}, {"p50", nullptr}, {"p95", nullptr}, {"count", 0}};
  return {{"mean", summary.mean}, {"p50", summary.p50}, {"p95", summary.p95}, {"count", summary.count}};
}

}  // namespace ctn::program
