// Why a plan is made; the words are the record's.
#pragma once

namespace ctn::policy {

enum class PlanReason { kBootstrap, kStatic, kMeasured, kPeriodic, kChange, kPower, kCpus, kAsked };
const char* to_string(PlanReason reason);

// What is made for this reason comes into force whatever the plan before is worth, which rests on no measurement, or is
// of other CPUs, weights or bounds.
inline bool is_unconditional(PlanReason reason) {
  return reason == PlanReason::kMeasured || reason == PlanReason::kCpus || reason == PlanReason::kAsked;
}

// Nothing has happened that makes the plan in force wrong.
inline bool is_routine(PlanReason reason) { return reason == PlanReason::kPeriodic; }

}  // namespace ctn::policy
