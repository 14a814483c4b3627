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
  enum class Kind { kCatan, kDefault, kRate };
  Kind kind = Kind::kCatan;
  std::optional<Rate> rate;  // kRate
  std::string name;          // as written

  bool plans() const { return kind == Kind::kCatan; }
};

// "catan", "default", "rate:30", "rate:12.5Hz". kCaller, naming all that would be right.
Result<Policy> parse_policy(std::string_view text);

// Hand-set rates, by subchain: kDefault takes each head's fallback_rate; kRate gives its rate to subchains whose head
// is a source, and the others their fallback_rate. kCaller names every head without one. Precondition: !policy.plans().
Result<std::vector<Rate>> hand_set_rates(const Policy& policy, const graph::App& app);

}  // namespace ctn::runtime
