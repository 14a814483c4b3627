// Which policy a session follows, and what that means for the triggers.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"

namespace ctn::runtime {

struct Policy {
  enum class Kind { kCatan, kDefault, kRate, kFifo, kStatic };
  Kind kind = Kind::kCatan;
  std::optional<Rate> rate;  // kRate
  std::string plan;          // kStatic: the file that it is in
  std::string name;          // as written

  // Follows a plan: its own, made anew as compute times change, or one that is given and never revised.
  bool follows_plan() const { return kind == Kind::kCatan || kind == Kind::kStatic; }
  // Needs real-time levels.
  bool raises() const { return follows_plan() || kind == Kind::kFifo; }
};

// "catan", "default", "fifo", "rate:30", "rate:12.5Hz", "static:PLAN.json". kCaller, naming all that would be right.
Result<Policy> parse_policy(std::string_view text);

// Hand-set rates, by subchain: kDefault and kFifo take each head's fallback_rate; kRate gives its rate to subchains
// whose head is a source, and the others their fallback_rate. kCaller names every head without one. Precondition:
// !policy.follows_plan().
Result<std::vector<Rate>> hand_set_rates(const Policy& policy, const graph::App& app);

}  // namespace ctn::runtime
