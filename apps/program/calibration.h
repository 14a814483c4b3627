// How a machine compares with the one that virtual time is like.
//
// In virtual time a run costs what its work was worth where that was measured. In life it costs what it costs: another
// processor, other caches, another driver. A run of the program in life knows both, so it tells of each node how many
// times as much CPU time its runs took as they were charged: the node's cost ratio. A run in virtual time that is given
// an outcome with these costs as much as life did, and what is left between the two is how they schedule.
//
// Thread safety: values; CostMeter as said there.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include <nlohmann/json_fwd.hpp>

#include "catan/result.h"
#include "catan/run.h"

namespace ctn::program {

// By node. Of nodes that are not in it runs cost what they are charged.
using CostRatios = std::map<std::string, double>;
double ratio_of(const CostRatios& ratios, const std::string& node);

// Measures them in a run in life.
class CostMeter {
 public:
  // `slowdown`: of a slower board, which runs in life take and are not charged. Of each node what begins within
  // `left_out` of its first run is left out: there code and data are fetched for the first time.
  CostMeter(double slowdown, std::chrono::nanoseconds left_out) : slowdown_(slowdown), left_out_(left_out) {}

  // The node's function, such that it is measured. Each node is to have one thread. The meter must outlive it.
  std::function<void(Run&)> metered(const std::string& node, std::function<void(Run&)> body);

  // Of nodes that were charged anything. Precondition: no function runs any more.
  CostRatios ratios() const;

 private:
  struct Costs {
    std::chrono::steady_clock::time_point counted_from{};
    std::chrono::nanoseconds used{0};
    std::chrono::nanoseconds charged{0};
  };
  double slowdown_;
  std::chrono::nanoseconds left_out_;
  std::map<std::string, Costs> costs_;  // each its node's thread's
};

// Those that runs in virtual time are to have.
class Calibration {
 public:
  Calibration() = default;  // none
  // Of what `path` says: the JSON outcome of a run in life, or a folder with those of a batch, `run-SEED.json`, of
  // which each run takes the one of its own seed: `runs` of them from `first_seed` on. Errors (kCaller): a file that is
  // not there, or has no cost ratios.
  static Result<Calibration> read(const std::string& path, std::uint64_t first_seed, int runs);

  const CostRatios& of(std::uint64_t seed) const;
  bool empty() const { return for_all_.empty() && by_seed_.empty(); }
  // Whether it has one for each seed.
  bool by_seed() const { return !by_seed_.empty(); }

 private:
  CostRatios for_all_;
  std::map<std::uint64_t, CostRatios> by_seed_;
};

// That of the options' `calibration_file`, if they name one. Errors: those of Calibration::read().
template <class Options>
Status read_calibration(Options& options) {
  if (options.calibration_file.empty()) return Done{};
  auto calibration = Calibration::read(options.calibration_file, options.seed, options.runs);
  if (!calibration) return calibration.error();
  options.calibration = std::move(calibration).value();
  return Done{};
}

}  // namespace ctn::program
