// What one run of a case study came to, as its program stores it: `run-SEED.json`, with `figures` (numbers by name,
// null where there was nothing to measure) and lists of numbers over time, named `..._by_5s` or so.
//
// Thread safety: values; read_runs() reads the file system.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "program/figures.h"

namespace ctn::case_studies {

using program::ByTime;

// What the runs of a batch have in common, each as JSON: "seconds", "inputs.world".
using RunOptions = std::map<std::string, std::string>;

struct StoredRun {
  std::uint64_t seed = 0;
  std::map<std::string, double> figures;  // those that were measured
  std::map<std::string, ByTime> by_time;
  RunOptions options{};  // those that its document names (program::common_options_in)

  std::optional<double> figure(const std::string& name) const;
};

// Of what a program prints with `--in-common`. None: it is no such document.
std::optional<RunOptions> parse_options(const std::string& text);

// Errors: kEnvironment, naming `file`, where the text is no outcome of a run, or does not say what is in common.
Result<StoredRun> parse_run(const std::string& text, const std::string& file);

// The runs with seeds from `first` on that are there, in the order of their seeds. Errors: as parse_run().
Result<std::vector<StoredRun>> read_runs(const std::filesystem::path& folder, std::uint64_t first, int count);

// Of a list over time: its median for each stretch, over the runs that have one there. Stretches that fewer than half
// of the runs reached are left out, as they tell of other runs than those before.
ByTime medians_by_time(const std::vector<StoredRun>& runs, const std::string& name);

// The same for comparing, where what starves must count: runs that had nothing in a stretch count as infinite.
ByTime medians_with_never(const std::vector<StoredRun>& runs, const std::string& name);
// The same of a list of periods. A stretch in which nothing came lies between two outputs, so it has the period that
// the next one tells; after the last one, that of the last. Runs that have none at all count as infinite.
ByTime medians_of_periods(const std::vector<StoredRun>& runs, const std::string& name);

// The mean of a list's values in a part of the run, from one share of its length to another; nothing where there are
// none.
std::optional<double> mean_between(const StoredRun& run, const std::string& name, double from, double to);

}  // namespace ctn::case_studies
