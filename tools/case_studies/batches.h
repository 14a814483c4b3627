// What studies put their batches and metrics together from: schedulers, and under which conditions they run.
//
// Thread safety: values, pure functions.
#pragma once

#include <string>
#include <vector>

#include "studies.h"

namespace ctn::case_studies {

using Arguments = std::vector<std::string>;

struct Scheduler {
  const char* name;  // of a batch
  const char* label;
  const char* option;      // of --scheduler
  const char* costs = "";  // the measurement that it plans by
  bool stealing = true;
};

inline constexpr Scheduler kCatan{"catan", "Catan", "catan"};
inline constexpr Scheduler kDefault{"default", "default", "default"};
inline constexpr Scheduler kPaper{"paper", "the paper's Catan", "paper"};

struct Conditions {
  Arguments world{};  // which one, where the program has several
  double seconds = 0.0;
  int runs = 0;
  Arguments where{};  // in virtual time, or on which CPU
  Arguments more{};
};

// How many runs, and for how long.
struct Size {
  int runs;
  double seconds;
};

// In virtual time on one core, and no more than the setting lets.
Conditions conditions_of(const Setting& setting, Arguments world, Size whole, Size quick);

Arguments in_virtual_time(int cores);

Arguments arguments_of(const Conditions& conditions, const Scheduler& scheduler);

// Catan's is the reference.
std::vector<Batch> batches_of(const std::vector<Scheduler>& schedulers, const Conditions& conditions);

// Adds batches that are compared among themselves.
void add_group(Study& study, const std::string& group, std::vector<Batch> batches);

// Adds a group a scheduler: the conditions on a CPU in real time, and in virtual time, which is its reference and whose
// runs cost as much as life's of the same seed.
void add_life(Study& study, const std::vector<Scheduler>& schedulers, Conditions conditions, int cpu);

// Of a figure that runs have by that name.
Metric metric(std::string name, const std::string& figure, Better better, Method method, int digits = 1);

}  // namespace ctn::case_studies
