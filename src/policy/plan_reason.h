// Why a plan is made; the words are the record's.
#pragma once

namespace ctn::policy {

enum class PlanReason { kBootstrap, kStatic, kMeasured, kPeriodic, kChange, kPower, kCpus, kAsked };
const char* to_string(PlanReason reason);

// Nothing has happened that makes the plan in force wrong.
inline bool is_routine(PlanReason reason) { return reason == PlanReason::kPeriodic; }

}  // namespace ctn::policy
