#include "navigation_studies.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "batches.h"
#include "claims.h"
#include "comparison.h"
#include "figures.h"

namespace ctn::case_studies {
namespace {

constexpr const char* kLocalChain = "laser -> scan -> LM -> LP -> base";
constexpr const char* kStaleness = "staleness_ms_p95_by_5s";
constexpr const char* kObjectiveOverTime = "objective_ms_by_10s";
constexpr const char* kDetectorPeriod = "detector_period_ms_by_10s";

// The names of metrics that claims and figures look for.
constexpr const char* kCollision = "Runs with a collision";
constexpr const char* kResponse = "Response time of the local chain, mean (ms)";
constexpr const char* kStale = "Staleness of the odometry, 95th percentile of a run (ms)";
constexpr const char* kExplored = "Time to explore 90 % (s)";
constexpr const char* kObjective = "Weighted objective (ms)";
constexpr const char* kFirstPeriod = "Period of the detector's output, first half of the run (ms)";
constexpr const char* kLastPeriod = "Period of the detector's output, second half (ms)";
constexpr const char* kLastStale = "Staleness of the odometry, second half (ms)";
constexpr const char* kScore = "BARN score";
constexpr const char* kReaction = "Reaction time, mean of a run (ms)";

constexpr const char* kWholeRun = "whole-run";
constexpr const char* kFirst20s = "first-20s";

constexpr Scheduler kFastLocal{"fast-local", "fast local", "fast-local"};
constexpr Scheduler kStaticFullRun{"static-full-run", "Static-FullRun", "static-full-run", kWholeRun};
constexpr Scheduler kStatic20s{"static-20s", "Static-20s", "static-20s", kFirst20s};

Metric mean_of_part(std::string name, const std::string& list, double from, double to) {
  return {.name = std::move(name),
          .value = [list, from, to](const StoredRun& run) { return mean_between(run, list, from, to); },
          .missing = kNever};
}

Metric collision_metric(Better better = Better::kLower) {
  return metric(kCollision, "collided", better, Method::kShares);
}

// What did not come to anything in a run that should have: later than all others, or what starves would not count.
Metric or_never(Metric metric) {
  metric.missing = kNever;
  return metric;
}

Metric response_metric(Better better = Better::kLower) {
  return or_never(metric(kResponse, std::string("response_ms_mean ") + kLocalChain, better, Method::kRanks));
}

Metric objective_metric() { return or_never(metric(kObjective, "objective_ms", Better::kLower, Method::kRanks)); }

Metric score_metric(Method method) { return metric(kScore, "barn_score", Better::kHigher, method, 3); }

Conditions in_world(const Setting& setting, const std::string& map, Size whole, Size quick) {
  return conditions_of(setting, {"--map", map}, whole, quick);
}

// What the static schedulers and other methods plan by: one run under Catan on one core, of a world and seed that no
// batch has.
std::vector<Measurement> measurements_of(Conditions conditions) {
  conditions.where = in_virtual_time(1);
  const Arguments whole = arguments_of(conditions, kCatan);
  const double seconds = conditions.seconds;
  conditions.seconds = std::min(seconds, 20.0);
  return {{kWholeRun, whole, seconds}, {kFirst20s, arguments_of(conditions, kCatan), conditions.seconds}};
}

std::vector<Claim> claims_of_collisions(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  const Share by_default = row_of(rows, kCollision, "default").share;
  const Share ours = row_of(rows, kCollision, "catan").share;
  return {{.text = "The world is hard: default has a collision in more than half of the runs",
           .measured = text_of(by_default),
           .probability = {},
           .verdict = verdict_of(percent_of(by_default) > 50.0)},
          {.text = "Catan has one in at most one run of 40",
           .measured = text_of(ours),
           .probability = {},
           .verdict = verdict_of(percent_of(ours) <= 2.5)},
          worse_than_reference("Catan has one in fewer runs than default", rows, kCollision, "default", "catan"),
          worse_than_reference("Catan has one in fewer runs than fast local", rows, kCollision, "fast-local", "catan")};
}

std::vector<Claim> claims_of_exploration(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  std::vector<Claim> claims{
      lowest_in(95.0,
                "Catan's staleness is lower than that of default and of the paper's Catan with and without stealing in "
                "95 % of the stretches",
                lowest_by_time(runs, "catan", {"default", "paper", "paper-without-stealing"}, kStaleness)),
      lowest_in(50.0, "The paper's Catan: staleness is lower with stealing than without in half of the stretches",
                lowest_by_time(runs, "paper", {"paper-without-stealing"}, kStaleness)),
      no_better_than_reference("Catan takes no longer than default to explore 90 % (median, s)", rows, kExplored,
                               "default", "catan")};
  for (const char* other : {"default", "paper"}) {
    claims.push_back(
        worse_than_reference(fmt::format("Catan's staleness over whole runs is lower than that of '{}'", other), rows,
                             kStale, other, "catan"));
  }
  return claims;
}

Claim at_most_times(const std::string& text, const Runs& runs, const std::string& ours, const std::string& other) {
  const double median = median_of_periods(runs, ours, kDetectorPeriod);
  const double theirs = median_of_periods(runs, other, kDetectorPeriod);
  return {.text = text,
          .measured = fmt::format("{:.0f} ms beside {:.0f} ms ({:.2f} times)", median, theirs, median / theirs),
          .probability = {},
          .verdict = verdict_of(median != kNever && median <= 0.6 * theirs)};
}

std::vector<Claim> claims_of_detector(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  return {worse_than_reference("1 core: the detector's period is shorter than Static-FullRun's in the first half", rows,
                               kFirstPeriod, "1-core/static-full-run", "1-core/catan"),
          worse_than_reference("1 core: staleness is lower than Static-20s's in the second half", rows, kLastStale,
                               "1-core/static-20s", "1-core/catan"),
          worse_than_reference("1 core: the weighted objective of whole runs is lower than Static-FullRun's", rows,
                               kObjective, "1-core/static-full-run", "1-core/catan"),
          worse_than_reference("1 core: the weighted objective of whole runs is lower than Static-20s's", rows,
                               kObjective, "1-core/static-20s", "1-core/catan"),
          lowest_in(95.0, "1 core: the weighted objective is lower than that of both in 95 % of the stretches",
                    lowest_by_time(runs, "1-core/catan", {"1-core/static-full-run", "1-core/static-20s"},
                                   kObjectiveOverTime)),
          at_most_times("2 cores: the detector's period is at most 0.6 of Static-FullRun's", runs, "2-cores/catan",
                        "2-cores/static-full-run"),
          at_most_times("2 cores: the detector's period is at most 0.6 of Static-20s's", runs, "2-cores/catan",
                        "2-cores/static-20s")};
}

constexpr const char* kReactionP95 = "Reaction time, 95th percentile of a run (ms)";

std::vector<Claim> claims_of_crowds(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  return {best_of_all("Catan's mean BARN score is the best of all schedulers", rows, kScore, "catan"),
          best_of_all("Catan's mean reaction time is the best of all schedulers", rows, kReaction, "catan"),
          best_of_all("Catan's reaction time in the 95th percentile is the best of all", rows, kReactionP95, "catan")};
}

const std::vector<double>& factors() {
  static const std::vector<double> kFactors{0.5, 1.0, 1.5, 2.0};
  return kFactors;
}

std::string group_of(double factor) { return fmt::format("speed-{}", factor); }

std::vector<Drawn> draw_speeds(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  report::Panel panel{.title = kCollision,
                      .x = {.label = "Speed of what moves, as a multiple of the map's", .min = 0.0},
                      .y = {.label = "% of the runs", .min = 0.0, .max = 100.0}};
  for (const Scheduler& scheduler : {kDefault, kFastLocal, kCatan}) {
    report::Series series{.label = scheduler.label, .colour = colour_of(scheduler.name)};
    for (const double factor : factors()) {
      const Share share = row_of(rows, kCollision, group_of(factor) + "/" + scheduler.name).share;
      const Interval interval = wilson(share);
      series.points.push_back({factor, percent_of(share), 100.0 * interval.low, 100.0 * interval.high});
    }
    panel.series.push_back(std::move(series));
  }
  return {{{.title = study.title, .panels = {std::move(panel)}, .width = 760, .panel_height = 360},
           "Lower is better. Bars are 95 % intervals."}};
}

std::vector<Claim> claims_of_speeds(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  std::vector<Claim> claims;
  for (const Scheduler& scheduler : {kDefault, kFastLocal}) {
    std::size_t held = 0;
    std::vector<std::string> measured;
    for (const double factor : factors()) {
      const Share ours = row_of(rows, kCollision, group_of(factor) + "/catan").share;
      const Share theirs = row_of(rows, kCollision, group_of(factor) + "/" + scheduler.name).share;
      held += percent_of(ours) <= percent_of(theirs) ? 1U : 0U;
      measured.push_back(fmt::format("{}: {} beside {}", factor, ours.count, theirs.count));
    }
    claims.push_back({.text = fmt::format("Catan has collisions in no more runs than {} at any speed", scheduler.label),
                      .measured = fmt::format("{}", fmt::join(measured, "; ")),
                      .probability = {},
                      .verdict = verdict_of(held == factors().size())});
  }
  return claims;
}

std::vector<Claim> claims_of_life(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  std::vector<Claim> claims;
  for (const Scheduler& scheduler : {kDefault, kFastLocal, kCatan}) {
    const std::string name = scheduler.name;
    const Row& in_life = row_of(rows, kCollision, name + "/life");
    const Row& simulated = row_of(rows, kCollision, name + "/virtual");
    claims.push_back(
        no_difference(fmt::format("{}: collisions in life and in virtual time differ by chance alone", scheduler.label),
                      compare_two(*in_life.metric, *in_life.batch, *simulated.batch, runs), simulated));
    const double life = median_of(row_of(rows, kResponse, name + "/life"));
    const double virtually = median_of(row_of(rows, kResponse, name + "/virtual"));
    const double off = 100.0 * (virtually / life - 1.0);
    claims.push_back(
        {.text = fmt::format("{}: the local chain's response time in virtual time is within 10 % of life's",
                             scheduler.label),
         .measured = fmt::format("{:.1f} ms in life, {:.1f} ms in virtual time ({:+.0f} %)", life, virtually, off),
         .probability = {},
         .verdict = verdict_of(off >= -10.0 && off <= 10.0)});
  }
  return claims;
}

}  // namespace

Study collisions(const Setting& setting) {
  const Conditions conditions = in_world(setting, setting.map1, {40, 90.0}, {5, 60.0});
  return {.id = "map1",
          .program = "navigation",
          .title = "Collisions on map 1 (the paper's figure 8)",
          .text =
              "The robot goes from one room to the other, past things that move, on one core. Of interest is in how "
              "many runs it touches anything.",
          .missing = {},
          .measurements = {},
          .batches = batches_of({kDefault, kFastLocal, kCatan}, conditions),
          .metrics = {collision_metric(),
                      metric("Runs that reached the goal", "reached_goal", Better::kHigher, Method::kShares),
                      or_never(metric("Time to the goal (s)", "goal_s", Better::kLower, Method::kRanks)),
                      score_metric(Method::kRanks),
                      metric(kReaction, "reaction_ms_mean", Better::kLower, Method::kRanks), response_metric()},
          .draw = [](const Study& study, const Runs& runs) -> std::vector<Drawn> {
            return {{by_batch(study, runs, kCollision), "Lower is better. Bars are 95 % intervals."}};
          },
          .claim = claims_of_collisions};
}

Study exploration(const Setting& setting) {
  const Conditions conditions = in_world(setting, setting.map2, {20, 450.0}, {2, 75.0});
  constexpr Scheduler kPaperWithout{"paper-without-stealing", "the paper's Catan without stealing", "paper", "", false};
  constexpr Scheduler kCatanWithout{"catan-without-stealing", "Catan without stealing", "catan", "", false};
  return {.id = "map2",
          .program = "navigation",
          .title = "Staleness while a building is explored, map 2 (figure 9)",
          .text =
              "The robot explores an office floor on one core; maps and plans grow with what it has seen. Of "
              "interest is how old the odometry is that a navigation command goes back to: the 95th percentile in "
              "each 5 s, and of that the median of all runs.",
          .missing = {},
          .measurements = {},
          .batches = batches_of({kCatan, kDefault, kPaper, kPaperWithout, kCatanWithout}, conditions),
          .metrics = {or_never(metric(kStale, "staleness_ms_p95", Better::kLower, Method::kRanks, 0)),
                      or_never(metric("Staleness of the odometry, mean of a run (ms)", "staleness_ms_mean",
                                      Better::kLower, Method::kRanks, 0)),
                      or_never(metric(kExplored, "explored_90_s", Better::kLower, Method::kRanks)), objective_metric(),
                      response_metric()},
          .draw = [](const Study& study, const Runs& runs) -> std::vector<Drawn> {
            return {{over_time(
                         study, runs,
                         {.batches = {"default", "paper-without-stealing", "paper", "catan-without-stealing", "catan"},
                          .list = kStaleness,
                          .stretch = 5.0,
                          .title = "Staleness of the odometry, 95th percentile",
                          .unit = "ms"}),
                     "Lower is better. Times that fewer than half of the runs reached are left out."}};
          },
          .claim = claims_of_exploration};
}

Study detector(const Setting& setting) {
  Conditions conditions = in_world(setting, setting.map2, {20, 300.0}, {2, 75.0});
  conditions.more = setting.detector;
  const std::vector<Scheduler> schedulers{kStaticFullRun, kStatic20s, kCatan};
  Study study{
      .id = "detector",
      .program = "navigation",
      .title = "With a detector beside navigation, one core and two (figures 10, 11, 12)",
      .text =
          "As before, and a detector looks at a camera's pictures, with very little weight. The static "
          "schedulers have a plan that was made once, of the compute times of a whole run or of its first "
          "20 s on one core; on two cores they have its rates, under ordinary scheduling.",
      .missing = {},
      .measurements = measurements_of(conditions),
      .batches = {},
      .metrics = {mean_of_part(kFirstPeriod, kDetectorPeriod, 0.0, 0.5),
                  mean_of_part(kLastPeriod, kDetectorPeriod, 0.5, 1.0), mean_of_part(kLastStale, kStaleness, 0.5, 1.0),
                  objective_metric(), or_never(metric(kExplored, "explored_90_s", Better::kLower, Method::kRanks)),
                  response_metric()},
      .draw = {},
      .claim = claims_of_detector};
  for (const int cores : {1, 2}) {
    conditions.where = in_virtual_time(cores);
    std::vector<Batch> batches = batches_of(schedulers, conditions);
    for (Batch& batch : batches) batch.label += cores == 1 ? ", 1 core" : ", 2 cores";
    add_group(study, cores == 1 ? "1-core" : "2-cores", std::move(batches));
  }
  study.draw = [](const Study& of, const Runs& runs) -> std::vector<Drawn> {
    const std::vector<std::string> one{"1-core/static-full-run", "1-core/static-20s", "1-core/catan"};
    const std::vector<std::string> two{"2-cores/static-full-run", "2-cores/static-20s", "2-cores/catan"};
    return {{over_time(of, runs, {one, kDetectorPeriod, 10.0, "Period of the detector's output, one core", "ms"}),
             "Lower is better."},
            {over_time(of, runs, {one, kStaleness, 5.0, "Staleness of the odometry, one core", "ms"}),
             "Lower is better, and counts for more than the detector."},
            {over_time(of, runs, {one, kObjectiveOverTime, 10.0, "Weighted objective, one core", "ms"}),
             "Lower is better: what the app asks for, local chain, localisation and detector by their weights."},
            {over_time(of, runs, {two, kDetectorPeriod, 10.0, "Period of the detector's output, two cores", "ms"}),
             "Lower is better."}};
  };
  return study;
}

Study crowds(const Setting& setting) {
  const Conditions conditions = in_world(setting, "crowd", {100, 120.0}, {3, 60.0});
  const auto by_costs = [](const char* name, const char* label) { return Scheduler{name, label, name, kWholeRun}; };
  const Metric missed{.name = "What appeared and was missed (%)",
                      .value = [](const StoredRun& run) -> std::optional<double> {
                        const double all = run.figure("appearances").value_or(0.0);
                        if (all == 0.0) return std::nullopt;
                        return 100.0 * (1.0 - run.figure("reacted").value_or(0.0) / all);
                      },
                      .better = Better::kLower,
                      .method = Method::kPairs};
  return {.id = "crowds",
          .program = "navigation",
          .title = "Crowds",
          .text =
              "Each run is in another generated world with clutter and things that move, the same for all "
              "schedulers, on one core. The BARN score is 0.5 for a run straight to the goal and 0 with a contact; "
              "the reaction time is what passes from when something appears in the robot's way to the first "
              "velocity that takes it into account. Schedulers that plan once do so by the compute times of a run "
              "in another such world.",
          .missing = {},
          .measurements = measurements_of(conditions),
          .batches = batches_of(
              {kCatan, kPaper, kDefault, kFastLocal, kStaticFullRun, kStatic20s, by_costs("davare", "Davare"),
               by_costs("verucchi", "Verucchi"), by_costs("picas", "PiCAS"), by_costs("deadline", "deadline")},
              conditions),
          .metrics = {score_metric(Method::kPairs), collision_metric(),
                      metric(kReaction, "reaction_ms_mean", Better::kLower, Method::kPairs, 0),
                      metric(kReactionP95, "reaction_ms_p95", Better::kLower, Method::kPairs, 0), missed},
          .draw = [](const Study& study, const Runs& runs) -> std::vector<Drawn> {
            return {{by_batch(study, runs, kScore), "Higher is better. Bars are 95 % intervals of the mean."},
                    {by_batch(study, runs, kReaction), "Lower is better. Bars are 95 % intervals of the mean."}};
          },
          .claim = claims_of_crowds};
}

Study speeds(const Setting& setting) {
  Conditions conditions = in_world(setting, setting.map1, {20, 90.0}, {2, 60.0});
  Study study{.id = "speeds",
              .program = "navigation",
              .title = "Map 1 with things that move slower and faster",
              .text = "The first study again, with the speed of all that moves multiplied.",
              .missing = {},
              .measurements = {},
              .batches = {},
              .metrics = {collision_metric(), score_metric(Method::kRanks)},
              .draw = draw_speeds,
              .claim = claims_of_speeds};
  for (const double factor : factors()) {
    conditions.more = {"--mover-speed", fmt::format("{}", factor)};
    std::vector<Batch> batches = batches_of({kDefault, kFastLocal, kCatan}, conditions);
    for (Batch& batch : batches) batch.label += fmt::format(", {} times as fast", factor);
    add_group(study, group_of(factor), std::move(batches));
  }
  return study;
}

Study life(const Setting& setting) {
  Study study{.id = "life",
              .program = "navigation",
              .title = "Virtual time beside life",
              .text =
                  "The first study again, with the same seeds in real time, one run after the other and nothing "
                  "else beside them; and in virtual time. There runs of each node cost as many times what they are "
                  "charged as in the run in life with the same seed, so that what differs is how they are scheduled.",
              .missing = setting.no_life,
              .measurements = {},
              .batches = {},
              .metrics = {collision_metric(Better::kNeither), response_metric(Better::kNeither),
                          metric(kReaction, "reaction_ms_mean", Better::kNeither, Method::kRanks)},
              .draw = {},
              .claim = claims_of_life};
  add_life(study, {kDefault, kFastLocal, kCatan}, in_world(setting, setting.map1, {10, 90.0}, {2, 15.0}), setting.cpu);
  return study;
}

}  // namespace ctn::case_studies
