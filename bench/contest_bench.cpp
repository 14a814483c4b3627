// Catan against other policies, in the simulator: over the frozen case studies and over random apps. docs/benchmarks.md
// says how to read it.
//
//   contest_bench [--quick]
//   contest_bench --policies catan,plan:auto:0.3,verucchi,davare --judged catan,plan:auto:0.3
//   contest_bench --cases none --random 1 --first 17 --cores 2      one random app again
//   contest_bench --app-seed 17 --write DIR                         its files, for catan plan and catan sim
//
// Exit: 0, whoever wins; 1 where files cannot be written; 2 for options that make no sense.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "contest.h"
#include "contest_apps.h"
#include "sim/batch.h"
#include "sim/simulation.h"

namespace {

using namespace ctn;
using namespace ctn::bench;
using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> policies{"catan", "verucchi", "davare", "picas", "fifo", "default"};
  std::vector<std::string> judged;
  std::vector<std::string> cases{"navigation", "navigation_with_detector", "vr"};
  std::vector<int> cores;
  double seconds = 60.0;
  int seeds = 5;
  int random = 40;
  std::uint64_t first = 1;
  std::size_t threads = 2;
  bool quick = false;
  bool json = false;
  std::optional<std::uint64_t> app_seed;
  std::string folder;
};

// One app on so many cores, and what each policy made of it.
struct Entry {
  const Case* of = nullptr;
  std::optional<std::uint64_t> app_seed;  // of a random app
  Match match;
  std::vector<Score> scores;  // by policy
};

using Figure = double (Score::*)() const;

struct Contest {
  Options options;
  std::deque<Case> apps;  // which entries point to
  std::vector<Entry> entries;

  bool judged(std::size_t policy) const {
    const auto& names = options.judged;
    return std::find(names.begin(), names.end(), options.policies[policy]) != names.end();
  }

  // Of an entry: one policy's figure to the lowest of all that are not judged.
  double ratio(const Entry& entry, std::size_t policy, Figure figure) const {
    std::vector<double> others;
    for (std::size_t other = 0; other < entry.scores.size(); ++other) {
      if (other != policy && !judged(other)) others.push_back((entry.scores[other].*figure)());
    }
    return ratio_to_best((entry.scores[policy].*figure)(), others);
  }

  // Its p95 to that of the policy, of those that are not judged, with the least objective.
  double p95_to_winners(const Entry& entry, std::size_t policy) const {
    const Score* winner = nullptr;
    for (std::size_t other = 0; other < entry.scores.size(); ++other) {
      if (other == policy || judged(other)) continue;
      const Score& score = entry.scores[other];
      if (winner == nullptr || score.mean_objective() < winner->mean_objective()) winner = &score;
    }
    if (winner == nullptr) return 1.0;
    return ratio_to_best(entry.scores[policy].mean_p95(), {winner->mean_p95()});
  }
};

void add_entries(Contest& contest, const Case& of, std::optional<std::uint64_t> app_seed, const std::vector<int>& cores,
                 int seeds) {
  Match match{.cores = 1, .seeds = {}, .measured = to_nanos(Millis{contest.options.seconds * 1000.0})};
  match.seeds.resize(static_cast<std::size_t>(seeds));
  std::iota(match.seeds.begin(), match.seeds.end(), std::uint64_t{1});
  for (const int count : cores) {
    match.cores = count;
    contest.entries.push_back({&of, app_seed, match, std::vector<Score>(contest.options.policies.size())});
  }
}

Contest prepared(const Options& options) {
  Contest contest{options, {}, {}};
  const auto cores_or = [&](std::vector<int> usual) { return options.cores.empty() ? usual : options.cores; };
  for (const std::string& name : options.cases) {
    if (name == "none") continue;
    add_entries(contest, contest.apps.emplace_back(frozen_case(name)), {}, cores_or({1, 2, 3}), options.seeds);
  }
  for (int i = 0; i < options.random; ++i) {
    const std::uint64_t seed = options.first + static_cast<std::uint64_t>(i);
    add_entries(contest, contest.apps.emplace_back(case_of(random_app(seed))), seed, cores_or({1, 2, 4}), 1);
  }
  for (const std::string& policy : options.policies) {
    if (contest.apps.empty()) break;
    if (const Status known = check_contender(policy, contest.apps.front().app); !known) {
      throw std::runtime_error(known.error().message());
    }
  }
  return contest;
}

void play_all(Contest& contest) {
  const std::size_t policies = contest.options.policies.size();
  const std::size_t count = contest.entries.size() * policies;
  std::mutex mutex;
  std::size_t done = 0;
  sim::for_each_in_parallel(count, contest.options.threads, [&](std::size_t index) {
    Entry& entry = contest.entries[index / policies];
    const std::string& policy = contest.options.policies[index % policies];
    Score score = play(policy, *entry.of, entry.match);
    const std::lock_guard lock(mutex);
    entry.scores[index % policies] = std::move(score);
    fmt::print(stderr, "... {} of {}: {}, {} cores, {}\n", ++done, count, entry.of->name, entry.match.cores, policy);
  });
}

// --- Text

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{:.2f}", value) : "-"; }

void print_head(const Contest& contest, const std::string& what) {
  fmt::print("\n{}\n{:<26} {:>5}", what, "case", "cores");
  for (const std::string& policy : contest.options.policies) fmt::print(" {:>13}", policy);
  fmt::print("   to the best other\n");
}

void print_cases(const Contest& contest, const std::string& what, Figure figure) {
  print_head(contest, what);
  for (const Entry& entry : contest.entries) {
    if (entry.app_seed) continue;
    fmt::print("{:<26} {:>5}", entry.of->name, entry.match.cores);
    for (const Score& score : entry.scores) fmt::print(" {:>13}", cell((score.*figure)()));
    for (std::size_t policy = 0; policy < entry.scores.size(); ++policy) {
      if (contest.judged(policy)) fmt::print("   {:.3f}", contest.ratio(entry, policy, figure));
    }
    fmt::print("\n");
  }
}

std::vector<int> cores_of_random(const Contest& contest) {
  std::vector<int> all;
  for (const Entry& entry : contest.entries) {
    if (entry.app_seed && std::find(all.begin(), all.end(), entry.match.cores) == all.end()) {
      all.push_back(entry.match.cores);
    }
  }
  return all;
}

struct Ratio {
  const Entry* entry;
  double value;
};
using RatioOf = std::function<double(const Entry&, std::size_t policy)>;

// Worst first.
std::vector<Ratio> random_ratios(const Contest& contest, int cores, std::size_t policy, const RatioOf& ratio_of) {
  std::vector<Ratio> ratios;
  for (const Entry& entry : contest.entries) {
    if (entry.app_seed && entry.match.cores == cores) ratios.push_back({&entry, ratio_of(entry, policy)});
  }
  std::stable_sort(ratios.begin(), ratios.end(), [](const Ratio& a, const Ratio& b) { return a.value > b.value; });
  return ratios;
}

Ratios summary_of(const std::vector<Ratio>& ratios) {
  std::vector<double> values;
  for (const Ratio& each : ratios) values.push_back(each.value);
  return bench::summary_of(values);
}

constexpr std::size_t kWorst = 5;

// A ratio over random apps: one line for each number of cores and judged policy.
void print_random(const Contest& contest, const std::string& what, const RatioOf& ratio_of) {
  fmt::print("\n{}\n{:<14} {:>5} {:>9} {:>11} {:>8} {:>9}   worst (app seed)\n", what, "judged", "cores", "geo. mean",
             "within 1 %", "first", "infinite");
  for (const int cores : cores_of_random(contest)) {
    for (std::size_t policy = 0; policy < contest.options.policies.size(); ++policy) {
      if (!contest.judged(policy)) continue;
      const std::vector<Ratio> ratios = random_ratios(contest, cores, policy, ratio_of);
      const Ratios sum = summary_of(ratios);
      fmt::print("{:<14} {:>5} {:>9.3f} {:>9.1f} % {:>6.1f} % {:>9}  ", contest.options.policies[policy], cores,
                 sum.geometric_mean, 100.0 * sum.within_a_percent, 100.0 * sum.first, sum.infinite);
      for (std::size_t i = 0; i < std::min(kWorst, ratios.size()); ++i) {
        fmt::print(" {:.2f} ({})", ratios[i].value, *ratios[i].entry->app_seed);
      }
      fmt::print("\n");
    }
  }
}

// Each policy's objective to that of the first policy.
void print_objectives_to_first(const Contest& contest) {
  const std::vector<std::string>& policies = contest.options.policies;
  fmt::print("\nObjective to that of {}, geometric means\n{:>5}", policies.front(), "cores");
  for (const std::string& policy : policies) fmt::print(" {:>13}", policy);
  fmt::print("\n");
  for (const int cores : cores_of_random(contest)) {
    fmt::print("{:>5}", cores);
    for (std::size_t policy = 0; policy < policies.size(); ++policy) {
      const std::vector<Ratio> ratios = random_ratios(contest, cores, policy, [](const Entry& entry, std::size_t of) {
        return ratio_to_best(entry.scores[of].mean_objective(), {entry.scores.front().mean_objective()});
      });
      fmt::print(" {:>13.3f}", summary_of(ratios).geometric_mean);
    }
    fmt::print("\n");
  }
}

void print_refusals(const Contest& contest) {
  std::size_t refused = 0;
  for (const Entry& entry : contest.entries) {
    for (std::size_t policy = 0; policy < entry.scores.size(); ++policy) {
      if (entry.scores[policy].refused.empty()) continue;
      if (refused++ == 0) fmt::print("\nRefused, and counted as infinite:\n");
      fmt::print("  {}, {} cores, {}: {}\n", entry.of->name, entry.match.cores, contest.options.policies[policy],
                 entry.scores[policy].refused);
    }
  }
}

void print_text(const Contest& contest) {
  const Options& options = contest.options;
  fmt::print("In the simulator, {} s after the warm-up. Judged: {}\n", options.seconds,
             fmt::join(options.judged, ", "));
  const bool cases = std::any_of(contest.entries.begin(), contest.entries.end(),
                                 [](const Entry& entry) { return !entry.app_seed.has_value(); });
  if (cases) {
    print_cases(contest, fmt::format("Weighted objective (ms), means of {} seeds", options.seeds),
                &Score::mean_objective);
    print_cases(contest, fmt::format("p95 of the chain that weighs most (ms), means of {} seeds", options.seeds),
                &Score::mean_p95);
  }
  if (options.random > 0) {
    fmt::print("\n{} random apps, seeds {} to {}\n", options.random, options.first,
               options.first + static_cast<std::uint64_t>(options.random) - 1);
    print_random(contest, "Objective, to the lowest of those not judged",
                 [&](const Entry& entry, std::size_t of) { return contest.ratio(entry, of, &Score::mean_objective); });
    print_random(contest, "p95 of the chain that weighs most, to the lowest of those not judged",
                 [&](const Entry& entry, std::size_t of) { return contest.ratio(entry, of, &Score::mean_p95); });
    print_random(contest, "The same, to that of the one that has the lowest objective",
                 [&](const Entry& entry, std::size_t of) { return contest.p95_to_winners(entry, of); });
    print_objectives_to_first(contest);
  }
  print_refusals(contest);
}

// --- JSON

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json numbers(const std::vector<double>& values) {
  Json all = Json::array();
  for (const double value : values) all.push_back(number(value));
  return all;
}

Json json_of(const Contest& contest, const Entry& entry) {
  Json policies = Json::array();
  for (std::size_t policy = 0; policy < entry.scores.size(); ++policy) {
    const Score& score = entry.scores[policy];
    policies.push_back({{"policy", contest.options.policies[policy]},
                        {"objective_ms", numbers(score.objective_ms)},
                        {"p95_ms", numbers(score.p95_ms)},
                        {"objective_to_best", number(contest.ratio(entry, policy, &Score::mean_objective))},
                        {"p95_to_lowest", number(contest.ratio(entry, policy, &Score::mean_p95))},
                        {"refused", score.refused.empty() ? Json(nullptr) : Json(score.refused)}});
  }
  return {{"app", entry.of->name},
          {"app_seed", entry.app_seed ? Json(*entry.app_seed) : Json(nullptr)},
          {"cores", entry.match.cores},
          {"seeds", entry.match.seeds},
          {"policies", policies}};
}

void print_json(const Contest& contest) {
  Json entries = Json::array();
  for (const Entry& entry : contest.entries) entries.push_back(json_of(contest, entry));
  const Json document{{"seconds", contest.options.seconds}, {"judged", contest.options.judged}, {"entries", entries}};
  fmt::print("{}\n", document.dump(1));
}

// --- Options

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error(fmt::format("cannot write {}; is its folder there?", path.string()));
}

int write_app(const Options& options) {
  const AppFiles files = random_app(*options.app_seed);
  const std::filesystem::path stem = std::filesystem::path(options.folder) / files.name;
  write(stem.string() + ".yaml", files.app);
  write(stem.string() + ".costs.yaml", files.costs);
  write(stem.string() + ".load.yaml", files.load);
  return EXIT_SUCCESS;
}

int run(Options options) {
  if (options.app_seed) return write_app(options);
  if (options.quick) {
    options.seconds = std::min(options.seconds, 20.0);
    options.seeds = 1;
    options.random = std::min(options.random, 10);
  }
  if (options.judged.empty()) options.judged = {options.policies.front()};
  Contest contest = prepared(options);
  play_all(contest);
  if (options.json) {
    print_json(contest);
  } else {
    print_text(contest);
  }
  return EXIT_SUCCESS;
}

void add_options(CLI::App& cli, Options& options) {
  cli.add_option("--policies", options.policies,
                 "Who plays: names as of catan sim --scheduler, and plan:auto[:EFFORT][:no-FEATURE]..., which is made "
                 "before and never revised")
      ->delimiter(',');
  cli.add_option("--judged", options.judged, "Of these, who is compared with all others; else the first")
      ->delimiter(',');
  cli.add_option("--cases", options.cases, "Frozen case studies, or none")
      ->delimiter(',')
      ->check(CLI::IsMember({"navigation", "navigation_with_detector", "vr", "none"}));
  cli.add_option("--random", options.random, "How many random apps")->check(CLI::Range(0, 100'000));
  cli.add_option("--first", options.first, "Seed of the first random app; the others follow");
  cli.add_option("--cores", options.cores, "Else 1,2,3 for the case studies and 1,2,4 for random apps")
      ->delimiter(',')
      ->check(CLI::Range(1, sim::kMaxCores));
  cli.add_option("--seconds", options.seconds, "Of virtual time, after the warm-up")->check(CLI::Range(0.1, 1e6));
  cli.add_option("--seeds", options.seeds, "How many loads of each case study; random apps have one")
      ->check(CLI::Range(1, 100'000));
  cli.add_option("--threads", options.threads, "Matches at once")->check(CLI::Range(1, 1024));
  cli.add_flag("--quick", options.quick, "At most 20 s, 1 seed and 10 random apps");
  cli.add_flag("--json", options.json, "Print one JSON document, of every figure");
  CLI::Option* folder = cli.add_option("--write", options.folder, "Where to write the files of --app-seed");
  cli.add_option("--app-seed", options.app_seed, "Write the files of this random app, and nothing else")->needs(folder);
  cli.get_option("--write")->needs("--app-seed");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("Catan against other policies, in the simulator");
  cli.option_defaults()->always_capture_default();
  add_options(cli, options);
  try {
    cli.parse(argc, argv);
    return run(options);
  } catch (const CLI::CallForHelp& help) {
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    cli.exit(error);
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "contest_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
