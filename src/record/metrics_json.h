// What was measured, as reports and simulations write it in JSON (docs/report-schema.md).
//
// Thread safety: pure functions.
#pragma once

#include <optional>

#include <nlohmann/json.hpp>

#include "catan/snapshot.h"

namespace ctn::record {

template <class Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

// null: there were no samples.
inline nlohmann::ordered_json to_json(const Summary& summary) {
  if (summary.count == 0) return nullptr;
  return {{"count", summary.count}, {"mean", summary.mean}, {"p50", summary.p50},
          {"p95", summary.p95},     {"p99", summary.p99},   {"max", summary.max}};
}

inline nlohmann::ordered_json to_json(const AgeSnapshot& edge) {
  return {{"from", edge.from},
          {"to", edge.to},
          {"max_age_ms", edge.max_age_ms},
          {"on_stale", edge.skips ? "skip" : "run"},
          {"runs", edge.runs},
          {"stale", edge.stale},
          {"age_ms", to_json(edge.age_ms)}};
}

}  // namespace ctn::record
