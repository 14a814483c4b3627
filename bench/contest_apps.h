// Random apps for contests of policies: whole apps as their files say them, with loads that vary, for the simulator.
// (planner/testing/random_apps.h makes others: values with one cost a node, of many odd kinds, for proofs of the
// planner.)
//
// What an app has:
//   - 2 to 12 subchains of 1 to 3 nodes. Costs (95th percentiles) are log-uniform from 0.3 to 150 ms; those of one
//     subchain are within a factor of nine, since its nodes work on the same data.
//   - 2 to 5 chains, each through whole subchains, some of which it enters at a later node than the head. Each subchain
//     is in one at least, so every node is. Half of the apps have a period in their objective too. Weights are
//     log-uniform from 0.005 to 1.
//   - Loads: runs of four nodes in five vary, with a median of 0.4 to 0.9 of the cost; three in ten have spikes, of
//     0.5 to 4 costs but at most 150 ms, in 0.3 to 3 % of their runs. Nothing grows: policies that decide once would
//     lose by that alone.
//   - Rates set by hand, for the policies that have no others. They use 70 % of one core at the planned costs; a
//     subchain has a part of that in proportion to the root of cost times weight, which makes the weighted sum of
//     periods least. Rates are rounded down to 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 and so on, and are the same on more
//     cores.
// There are no bounds, exact rates, rate caps, queues, modes and unscheduled nodes: the case studies have them.
//
// A seed gives the same text on every machine, so an app can be named by it.
//
// Units: in the files. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <string>

#include "cases.h"

namespace ctn::bench {

// The text of an app's files.
struct AppFiles {
  std::string name;   // "random_" and the seed
  std::string app;    // docs/app-file.md
  std::string costs;  // docs/cost-file.md: what is planned with
  std::string load;   // the same with how runs differ
};

AppFiles random_app(std::uint64_t seed);

// Of a random app or another. Throws std::runtime_error where the files are not accepted.
Case case_of(const AppFiles& files);

}  // namespace ctn::bench
