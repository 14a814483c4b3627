// For the test and the bench of change detection: compute times drawn run by run, the same everywhere.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "base/time.h"
#include "model/portable_math.h"

namespace ctn::model {

// What the next run costs.
using Draw = std::function<Nanos()>;

struct CaseLaw {
  double spread = 0.0;   // standard deviation of the logarithm; 0: always the same
  double spikes = 0.0;   // how probable one is
  double spike = 10.0;   // times as long
  double memory = 0.0;   // correlation of the logarithms of a run and the next
  bool uniform = false;  // from 0.5 to 1.5 instead
};

struct Case {
  const char* name;
  CaseLaw law;
};

inline std::vector<Case> unchanging_cases() {
  return {{"always the same", {}},
          {"log-normal, spread 0.1", {.spread = 0.1}},
          {"log-normal, spread 0.25", {.spread = 0.25}},
          {"log-normal, spread 0.5", {.spread = 0.5}},
          {"log-normal, spread 1", {.spread = 1.0}},
          {"uniform, 0.5 to 1.5", {.uniform = true}},
          {"spread 0.25, 5 % spikes of 10 x", {.spread = 0.25, .spikes = 0.05}},
          {"spread 0.25, 30 % spikes of 3 x", {.spread = 0.25, .spikes = 0.3, .spike = 3.0}},
          {"spread 0.25, each like the last (0.5)", {.spread = 0.25, .memory = 0.5}},
          {"spread 0.25, each like the last (0.9)", {.spread = 0.25, .memory = 0.9}}};
}

// Around 10 ms.
inline Draw draws(const CaseLaw& law, std::uint64_t seed) {
  // The engine is the same everywhere; the distributions of the standard library are not.
  auto uniform = [engine = std::mt19937_64(seed)]() mutable {
    return (static_cast<double>(engine() >> 12U) + 0.5) * 0x1p-52;
  };
  return [law, uniform, z = 0.0]() mutable {
    z = law.memory * z + std::sqrt(1.0 - law.memory * law.memory) * inverse_normal(uniform());
    double factor = law.uniform ? 0.5 + uniform() : portable_exp(law.spread * z);
    if (law.spikes > 0.0 && uniform() < law.spikes) factor *= law.spike;
    return Nanos{std::llround(10e6 * factor)};
  };
}

inline Nanos scaled(Nanos cpu, double factor) { return Nanos{std::llround(static_cast<double>(cpu.count()) * factor)}; }

}  // namespace ctn::model
