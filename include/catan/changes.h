// What is asked of a session, or of a server (`catan ctl`), to be different from now on, while it runs. What is left
// out stays as it is. Plain values.
//
// A term of the objective is named as the app file has it: by its place ("0" is the first), by its chain ("scan -> LM
// -> LP", or just its ends, "scan -> LP", where only one chain has these), or, if it is a period, by its node.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ctn {

struct Changes {
  struct Weight {
    std::string term;
    double weight = 0.0;
    friend bool operator==(const Weight&, const Weight&) = default;
  };
  // Bound of a response time; none: no bound any more.
  struct Max {
    std::string term;
    std::optional<double> max_ms{};
    friend bool operator==(const Max&, const Max&) = default;
  };
  // Bound of a node's rate; none: no bound any more.
  struct MinRate {
    std::string node;
    std::optional<double> min_rate_hz{};
    friend bool operator==(const MinRate&, const MinRate&) = default;
  };

  std::optional<std::vector<int>> cpus{};  // that nodes may use, of those that were given at the start
  std::vector<Weight> weights{};
  std::vector<Max> maxes{};
  std::vector<MinRate> min_rates{};

  friend bool operator==(const Changes&, const Changes&) = default;
};

}  // namespace ctn
