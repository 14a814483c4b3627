// One experiment: which runs it needs, what is compared in them, what is drawn and claimed. A new one is a function
// that returns a Study, and an entry in studies.cpp; running it (jobs.h), the tests of significance (comparison.h) and
// the page (page.h) are the same for all.
//
// Thread safety: values.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "report/plot.h"
#include "run.h"

namespace ctn::case_studies {

// Runs that differ in their seeds alone.
struct Batch {
  std::string name;   // of its folder, in the study's; unique there
  std::string label;  // for readers
  std::string group;  // batches are compared within their group: with the one of it that is the reference
  bool reference = false;
  std::vector<std::string> arguments;  // of the program, beside seeds, runs, folder and costs
  int runs = 0;
  std::string costs;          // the measurement whose record it plans by; empty: none
  bool live = false;          // in real time: nothing else may run meanwhile
  std::string calibration{};  // the batch in real time as in whose runs those of equal seeds cost; empty: none
  double seconds = 0;         // that a run lasts at most, for the estimate of the time left
};

// A run of its own, recorded, which says what runs of nodes cost.
struct Measurement {
  std::string name;
  std::vector<std::string> arguments;
  double seconds = 0;
};

enum class Better { kLower, kHigher, kNeither };

// By which test a metric is compared. kShares: of runs for which it is not 0, by Fisher's exact test. kRanks: by Mann
// and Whitney's. kPairs: runs of equal seeds are of the same world, by Wilcoxon's signed rank test.
enum class Method { kShares, kRanks, kPairs };

struct Metric {
  std::string name;  // "Time to explore 90 % (s)"
  std::function<std::optional<double>(const StoredRun&)> value;
  Better better = Better::kLower;
  Method method = Method::kRanks;
  int digits = 1;
  // Runs without a value count as this; none: they are left out.
  std::optional<double> missing{};
};

// By the batch's name.
using Runs = std::map<std::string, std::vector<StoredRun>>;

struct Drawn {
  report::Figure figure;
  std::string caption;
};

// kNotShown: it did not come out otherwise, but as chance may do, too.
enum class Verdict { kHeld, kNotShown, kFailed };

// What is expected, and what came out.
struct Claim {
  std::string text;
  std::string measured;
  std::optional<double> probability;  // of the test that decides it, where there is one
  Verdict verdict = Verdict::kFailed;
};

struct Study {
  std::string id;       // of its folder
  std::string program;  // the app's name
  std::string title;
  std::string text;     // what is done, and what to look at
  std::string missing;  // why it cannot be run here; empty: it can
  std::vector<Measurement> measurements;
  std::vector<Batch> batches;
  std::vector<Metric> metrics;
  std::function<std::vector<Drawn>(const Study&, const Runs&)> draw;
  std::function<std::vector<Claim>(const Study&, const Runs&)> claim;
};

// A study's figures and claims are asked for only where each batch has two runs at least.
bool is_complete_enough(const Study& study, const Runs& runs);

}  // namespace ctn::case_studies
