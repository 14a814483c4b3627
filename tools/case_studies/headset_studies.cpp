#include "headset_studies.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "batches.h"
#include "claims.h"
#include "comparison.h"
#include "figures.h"
#include "program/figures.h"

namespace ctn::case_studies {
namespace {

constexpr Scheduler kFifo{"fifo", "FIFO", "fifo"};
constexpr Scheduler kPacer{"pacer", "pacer", "pacer"};

const std::vector<Scheduler>& schedulers() {
  static const std::vector<Scheduler> kAll{kDefault, kFifo, kPaper, kPacer, kCatan};
  return kAll;
}

// Of a headset.
struct Chain {
  const char* name;
  const char* response;  // a metric's name, as the next
  const char* over_floor;
  int paper_percent;  // so much less than under its baselines the paper had
};
constexpr std::array<Chain, 3> kChains{
    {{"A", "Chain A, rotation: mean response time of a run (ms)", "Chain A above its floor (%)", 7},
     {"B", "Chain B, translation: mean response time of a run (ms)", "Chain B above its floor (%)", 25},
     {"C", "Chain C, camera to display: mean response time of a run (ms)", "Chain C above its floor (%)", 11}}};
constexpr const char* kErrorP50 = "Error of the picture, median of a run (pixels)";
constexpr const char* kErrorP95 = "Error of the picture, 95th percentile of a run (pixels)";
constexpr const char* kMissed = "Ticks missed (%)";

constexpr double kAtFloor = 1.0;  // percent above it: as low as can be, since costs vary a little

struct Cores {
  int count;
  const char* group;
  const char* label;
};
constexpr Cores kOne{1, "1-core", "1 core"};
constexpr Cores kTwo{2, "2-cores", "2 cores"};

std::string batch_on(const Cores& cores, const Scheduler& scheduler) {
  return fmt::format("{}/{}", cores.group, scheduler.name);
}

Metric response_of(const Chain& chain, Better better, Method method) {
  return metric(chain.response, fmt::format("response_ms {}_mean", chain.name), better, method, 2);
}

Metric missed_metric(Better better, Method method) {
  return {.name = kMissed,
          .value = [](const StoredRun& run) -> std::optional<double> {
            const double ticks = run.figure("ticks").value_or(0.0);
            if (ticks == 0.0) return std::nullopt;
            return 100.0 * run.figure("ticks_missed").value_or(0.0) / ticks;
          },
          .better = better,
          .method = method,
          .digits = 2};
}

// Runs of one seed are of one room, head's way and clocks, so all are compared in pairs.
std::vector<Metric> headset_metrics(bool camera_has_floor) {
  constexpr Method kPairs = Method::kPairs;
  std::vector<Metric> metrics;
  for (const Chain& chain : kChains) metrics.push_back(response_of(chain, Better::kLower, kPairs));
  for (const Chain& chain : kChains) {
    if (chain.name == std::string("C") && !camera_has_floor) continue;
    // It tells what the response time tells.
    const std::string figure = fmt::format("over_floor_percent {}", chain.name);
    metrics.push_back(metric(chain.over_floor, figure, Better::kNeither, kPairs));
  }
  metrics.push_back(metric(kErrorP50, "error_px_p50", Better::kLower, kPairs, 2));
  metrics.push_back(metric(kErrorP95, "error_px_p95", Better::kLower, kPairs, 2));
  metrics.push_back(metric("Error by the picture's age alone, 95th percentile (pixels)", "age_error_px_p95",
                           Better::kLower, kPairs, 3));
  metrics.push_back(missed_metric(Better::kLower, kPairs));
  metrics.push_back(metric("Pictures tracked a second", "vio_hz", Better::kNeither, kPairs));
  return metrics;
}

// That has room below a figure.
std::string short_label_of(const Scheduler& scheduler) {
  return scheduler.name == std::string(kPaper.name) ? "paper's Catan" : scheduler.label;
}

// A metric of all schedulers, on one core beside two: means, and one standard deviation above and below.
report::Panel panel_of(const std::vector<Row>& rows, const std::string& name) {
  constexpr double kApart = 0.1;
  report::Panel panel{.title = name, .y = {.min = 0.0}};
  for (const Cores& cores : {kOne, kTwo}) {
    const bool one = cores.count == 1;
    report::Series series{.label = cores.label,
                          .line = report::Line::kNone,
                          .colour = one ? report::Colour::kBlue : report::Colour::kOrange};
    double x = 0.0;
    for (const Scheduler& scheduler : schedulers()) {
      x += 1.0;
      if (one) panel.x.ticks.push_back({x, short_label_of(scheduler)});
      const Row& row = row_of(rows, name, batch_on(cores, scheduler));
      if (!row.spread) continue;
      const double mean = row.spread->mean;
      const double deviation = row.spread->deviation;
      series.points.push_back({x + (one ? -kApart : kApart), mean, mean - deviation, mean + deviation});
    }
    panel.series.push_back(std::move(series));
  }
  panel.x.min = 0.5;
  panel.x.max = static_cast<double>(schedulers().size()) + 0.5;
  return panel;
}

// The mean of what Catan's runs on one core have as the chain's.
std::optional<double> floor_of(const Chain& chain, const Runs& runs) {
  std::vector<double> floors;
  for (const StoredRun& run : runs.at(batch_on(kOne, kCatan))) {
    if (const auto floor = run.figure(fmt::format("floor_ms {}", chain.name))) floors.push_back(*floor);
  }
  return program::mean_of(floors);
}

// Catan's mean beside that of the better baseline, on one core: "A -7 %, B -25 %".
std::string gains_of(const std::vector<Row>& rows) {
  std::vector<std::string> gains;
  for (const Chain& chain : kChains) {
    const double ours = mean_of(row_of(rows, chain.response, batch_on(kOne, kCatan)));
    const double theirs = mean_of(lowest_mean(rows, chain.response, {batch_on(kOne, kDefault), batch_on(kOne, kFifo)}));
    gains.push_back(fmt::format("{} {:+.0f} %", chain.name, 100.0 * (ours / theirs - 1.0)));
  }
  return fmt::format("{}", fmt::join(gains, ", "));
}

std::vector<Drawn> draw_headset(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  report::Figure responses{.title = "Response times of the headset's chains", .width = 640, .panel_height = 280};
  std::vector<std::string> papers;
  for (const Chain& chain : kChains) {
    report::Panel& panel = responses.panels.emplace_back(panel_of(rows, chain.response));
    if (const auto floor = floor_of(chain, runs)) panel.levels.push_back({*floor, "floor"});
    papers.push_back(fmt::format("{} -{} %", chain.name, chain.paper_percent));
  }
  report::Figure errors{.title = "Error of the picture, and ticks missed", .width = 640, .panel_height = 280};
  for (const char* name : {kErrorP50, kErrorP95, kMissed}) errors.panels.push_back(panel_of(rows, name));
  return {
      {std::move(responses),
       fmt::format("Lower is better. Points are means of the runs, bars one standard deviation above and below. Catan "
                   "beside the better of default and FIFO, on one core: {}; in the paper about {}.",
                   gains_of(rows), fmt::join(papers, ", "))},
      {std::move(errors), "Lower is better. What the paper did not measure."}};
}

Claim near_floor(const Cores& cores, const Chain& chain, double percent, const std::vector<Row>& rows) {
  const Row& over = row_of(rows, chain.over_floor, batch_on(cores, kCatan));
  const Row& response = row_of(rows, chain.response, batch_on(cores, kCatan));
  return {.text = fmt::format("{}: Catan's {} is at most {:.0f} % above its floor", cores.label, chain.name, percent),
          .measured =
              over.spread ? fmt::format("mean {:+.1f} % ({:.2f} ms)", over.spread->mean, mean_of(response)) : "nothing",
          .probability = {},
          .verdict = verdict_of(mean_of(over) <= percent)};
}

void claim_errors(const std::vector<Row>& rows, std::vector<Claim>& claims) {
  for (const auto& [name, words] : {std::pair{kErrorP50, "median"}, std::pair{kErrorP95, "95th percentile"}}) {
    const Row& ours = row_of(rows, name, batch_on(kOne, kCatan));
    for (const Scheduler& baseline : {kDefault, kFifo}) {
      const Row& theirs = row_of(rows, name, batch_on(kOne, baseline));
      claims.push_back(
          lower_mean(fmt::format("1 core: Catan's picture has a smaller error than that of {} ({}, pixels)",
                                 baseline.label, words),
                     ours, theirs));
    }
  }
}

bool has_floor(const Study& study, const Chain& chain) {
  return std::ranges::find(study.metrics, chain.over_floor, &Metric::name) != study.metrics.end();
}

bool is_at_floor(const std::vector<Row>& rows, const Study& study, const Chain& chain, const Cores& cores) {
  return has_floor(study, chain) && mean_of(row_of(rows, chain.over_floor, batch_on(cores, kCatan))) <= kAtFloor;
}

void claim_beside_pacer(const Study& study, const std::vector<Row>& rows, std::vector<Claim>& claims) {
  for (const Chain& chain : kChains) {
    const Row& theirs = row_of(rows, chain.response, batch_on(kOne, kPacer));
    claims.push_back(no_higher_mean(
        fmt::format("1 core: Catan's {} is no longer than the pacer's, or at its floor (ms)", chain.name),
        row_of(rows, chain.response, batch_on(kOne, kCatan)), theirs, is_at_floor(rows, study, chain, kOne)));
  }
  const Row& theirs = row_of(rows, kMissed, batch_on(kOne, kPacer));
  claims.push_back(no_higher_mean("1 core: Catan misses no more ticks than the pacer (%)",
                                  row_of(rows, kMissed, batch_on(kOne, kCatan)), theirs));
}

void claim_more_cores(const Study& study, const Runs& runs, const std::vector<Row>& rows, std::vector<Claim>& claims) {
  const auto batch = [&](const Cores& cores) -> const Batch& {
    return *std::ranges::find(study.batches, batch_on(cores, kCatan), &Batch::name);
  };
  for (const Chain& chain : kChains) {
    const Row& two = row_of(rows, chain.response, batch_on(kTwo, kCatan));
    const Row one = compare_two(*two.metric, batch(kOne), batch(kTwo), runs);
    if (!has_floor(study, chain)) {
      claims.push_back(
          lower_mean(fmt::format("2 cores: Catan's {} is shorter than on one core (ms)", chain.name), two, one));
      continue;
    }
    claims.push_back(no_higher_mean(
        fmt::format("2 cores: Catan's {} is no longer than on one core, or at its floor (ms)", chain.name), two, one,
        is_at_floor(rows, study, chain, kTwo)));
  }
}

Claim far_below_baselines(const Chain& chain, double percent, const std::vector<Row>& rows) {
  const Row& theirs = lowest_mean(rows, chain.response, {batch_on(kOne, kDefault), batch_on(kOne, kFifo)});
  return lower_mean(fmt::format("1 core: Catan's {} is {:.0f} % shorter than the better of default and FIFO (ms)",
                                chain.name, percent),
                    row_of(rows, chain.response, batch_on(kOne, kCatan)), theirs, percent);
}

// With a camera that has a rate of its own C has a floor, too.
std::vector<Claim> claims_of_headset(const Study& study, const Runs& runs, bool camera_has_floor) {
  const std::vector<Row> rows = compare(study, runs);
  const auto& [a, b, c] = kChains;
  std::vector<Claim> claims{near_floor(kOne, a, 5.0, rows), near_floor(kOne, b, 10.0, rows),
                            camera_has_floor ? near_floor(kOne, c, 10.0, rows) : far_below_baselines(c, 20.0, rows)};
  claim_errors(rows, claims);
  claim_beside_pacer(study, rows, claims);
  claim_more_cores(study, runs, rows, claims);
  return claims;
}

Study headset_study(const Setting& setting, bool camera_has_rate) {
  Conditions conditions = conditions_of(setting, {}, {20, 30.0}, {2, 8.0});
  if (camera_has_rate) conditions.more = {"--camera", "20"};
  Study study{.id = {},
              .program = "vr",
              .title = {},
              .text = {},
              .missing = {},
              .measurements = {},
              .batches = {},
              .metrics = headset_metrics(camera_has_rate),
              .draw = draw_headset,
              .claim = [camera_has_rate](const Study& of, const Runs& runs) {
                return claims_of_headset(of, runs, camera_has_rate);
              }};
  for (const Cores& cores : {kOne, kTwo}) {
    conditions.where = in_virtual_time(cores.count);
    std::vector<Batch> batches = batches_of(schedulers(), conditions);
    for (Batch& batch : batches) batch.label += fmt::format(", {}", cores.label);
    add_group(study, cores.group, std::move(batches));
  }
  return study;
}

// How far a chain's response time in virtual time is from that in life: "A 11.2 in life, 11.4 (+2 %)".
struct Beside {
  std::string text;
  double percent_off = kNever;
};
Beside beside_life(const std::vector<Row>& rows, const Chain& chain, const std::string& scheduler) {
  const double life = mean_of(row_of(rows, chain.response, scheduler + "/life"));
  const double virtually = mean_of(row_of(rows, chain.response, scheduler + "/virtual"));
  if (life == kNever || virtually == kNever) return {fmt::format("{} nothing", chain.name), kNever};
  const double off = 100.0 * (virtually / life - 1.0);
  return {fmt::format("{} {:.1f} in life, {:.1f} ({:+.0f} %)", chain.name, life, virtually, off), off};
}

std::vector<Claim> claims_of_headset_life(const Study& study, const Runs& runs) {
  const std::vector<Row> rows = compare(study, runs);
  std::vector<Claim> claims;
  for (const Scheduler& scheduler : schedulers()) {
    std::vector<std::string> measured;
    bool held = true;
    for (const Chain& chain : kChains) {
      const Beside beside = beside_life(rows, chain, scheduler.name);
      measured.push_back(beside.text);
      held = held && beside.percent_off >= -10.0 && beside.percent_off <= 10.0;
    }
    claims.push_back(
        {.text = fmt::format("{}: A, B and C in virtual time are within 10 % of life's (ms)", scheduler.label),
         .measured = fmt::format("{}", fmt::join(measured, "; ")),
         .probability = {},
         .verdict = verdict_of(held)});
  }
  return claims;
}

}  // namespace

Study headset(const Setting& setting) {
  Study study = headset_study(setting, false);
  study.id = "headset";
  study.title = "A headset (the paper's figure 13)";
  study.text =
      "What the wearer sees at each tick of the display, on one core and on two; the camera takes a picture when it is "
      "triggered. Response times of the paper's chains: A, from the inertial unit to what is shown (rotation); B, the "
      "same through Render (translation); C, from the camera (how soon what was tracked is seen). The floor is what a "
      "chain comes to with nothing else on the cores. The paper compared Catan with default and FIFO; the pacer starts "
      "Timewarp and Render just in time, as the compositors of XR runtimes do. Runs of one seed are of one world, so "
      "they are compared in pairs.";
  return study;
}

Study headset_20hz(const Setting& setting) {
  Study study = headset_study(setting, true);
  study.id = "headset-20hz";
  study.title = "A headset whose camera has a rate of its own, 20 Hz";
  study.text =
      "As before, but the camera exposes 20 pictures a second by a clock of its own. C begins with the exposure, so "
      "that "
      "it has a floor, too.";
  return study;
}

Study headset_life(const Setting& setting) {
  Study study{.id = "headset-life",
              .program = "vr",
              .title = "A headset in virtual time beside life",
              .text =
                  "The headset with a triggered camera on one core again, with the same seeds in real time, one run "
                  "after the other and nothing else beside them; and in virtual time. In life all that the wearer sees "
                  "is drawn, and the camera gives the newest of pictures that were drawn before, 60 a second. In "
                  "virtual time runs of each node cost as many times what they are charged as in the run in life with "
                  "the same seed, so that what differs is how they are scheduled.",
              .missing = setting.no_life,
              .measurements = {},
              .batches = {},
              .metrics = {},
              .draw = {},
              .claim = claims_of_headset_life};
  for (const Chain& chain : kChains) study.metrics.push_back(response_of(chain, Better::kNeither, Method::kRanks));
  study.metrics.push_back(missed_metric(Better::kNeither, Method::kRanks));
  add_life(study, schedulers(), conditions_of(setting, {}, {5, 20.0}, {2, 5.0}), setting.cpu);
  return study;
}

}  // namespace ctn::case_studies
