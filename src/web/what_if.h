// A what-if question of a client: what would be planned, and what would be expected, if something were different.
//
// Thread safety: plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "catan/changes.h"

namespace ctn::web {

constexpr int kMaxCoresAsked = 64;

struct WhatIf {
  // `text` is as the client wrote it: "5ms", what a run of the node would cost at the percentile that is planned with;
  // "x2", that many times what was measured.
  struct Cost {
    std::string node;
    std::string text;
    friend bool operator==(const Cost&, const Cost&) = default;
  };
  Changes changes{};
  std::vector<Cost> costs{};
  std::optional<int> cores{};  // 1 to kMaxCoresAsked; none: as many as there are
  friend bool operator==(const WhatIf&, const WhatIf&) = default;
};

}  // namespace ctn::web
