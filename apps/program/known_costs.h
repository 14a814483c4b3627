// Schedulers that decide by compute times that have to be known before a run, and what policy of a session they are.
//
//   static-full-run   the plan that Catan would make of a whole run's compute times, on one core; then it stays. On
//                     more cores its rates are set by hand, under ordinary scheduling, as in the paper
//   static-20s        the same, of the first 20 s
//   davare, verucchi, picas, deadline: decide once, by the compute times of a whole run
//
// Compute times are from a file, or else measured by a run of its own, under Catan on one core.
//
// Thread safety: pure, but for the files.
#pragma once

#include <optional>
#include <string>

#include "catan/result.h"
#include "program/temporary_folder.h"

namespace ctn::program {

bool needs_costs(const std::string& scheduler);

// What is wrong with --costs and --cpus of these options. `those`: the schedulers of the app that decide by compute
// times, beside the static plans: "davare or picas".
template <class Options>
std::optional<std::string> mistake_about_costs(const Options& options, const std::string& those) {
  if (needs_costs(options.scheduler) && !options.virtual_time && options.cpus.empty()) {
    return "--scheduler " + options.scheduler +
           " needs --cpus in real time, as what it does depends on how many there are; write --cpus 0, or add "
           "--virtual";
  }
  if (!options.costs.empty() && !needs_costs(options.scheduler)) {
    return "--costs: '" + options.scheduler +
           "' does not decide by compute times that are given; leave it out, or use static-full-run, static-20s, " +
           those;
  }
  return std::nullopt;
}

// How long the run lasts, at most, that measures for a run of so many seconds.
double measuring_seconds(const std::string& scheduler, double seconds);

// With options of an app: whether its nodes have one core.
template <class Options>
bool has_one_core(const Options& options) {
  return options.virtual_time ? options.cores == 1 : options.cpus.size() == 1;
}

// Options of a run whose record says what runs with `options` cost: under Catan, on one core.
template <class Options>
Options measuring(const Options& options, const std::string& record) {
  Options result = options;
  result.scheduler = result.policy = "catan";
  result.stealing = true;
  result.cores = 1;
  if (!options.virtual_time) result.cpus.resize(1);
  result.seconds = measuring_seconds(options.scheduler, options.seconds);
  result.record = record;
  result.pictures.clear();
  return result;
}

// The session's policy, by the compute times in the file `costs` (a cost file or a record). `folder` has its files, and
// must outlive the run. Precondition: the scheduler needs costs. Errors: those of planning; a file that cannot be made.
Result<std::string> policy_by_costs(const std::string& scheduler, const std::string& costs, const std::string& app_file,
                                    bool one_core, const TemporaryFolder& folder);

}  // namespace ctn::program
