#include "page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "experiments/host.h"
#include "look.h"
#include "report/html.h"

namespace ctn::demo {
namespace {

std::string cores_text(std::size_t cores) { return cores == 1 ? "1 core" : fmt::format("{} cores", cores); }

std::string shown(const Spread& spread, int digits) {
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", spread.median, digits, spread.min, digits, spread.max, digits);
}

std::string scheduler_text(const Row& row) {
  if (row.scheduler == "default") return "default (30 Hz)";
  if (row.scheduler == "catan") return "Catan";
  return fmt::format("{:.1f} Hz by hand", row.source_hz.median);
}

std::vector<std::size_t> core_counts(const Summary& summary) {
  std::vector<std::size_t> counts;
  for (const Row& row : summary.rows) {
    if (std::ranges::find(counts, row.cores) == counts.end()) counts.push_back(row.cores);
  }
  return counts;
}

report::Point point_of(const Row& row, const Spread& value) {
  return {.x = row.source_hz.median, .y = value.median, .low = value.min, .high = value.max};
}

report::Panel panel_of(const Summary& summary, std::size_t cores, double speed, Spread Row::*value,
                       const std::string& unit) {
  report::Panel panel{.title = cores_text(cores), .x = {.label = "Source rate (Hz)", .min = 0.0}, .y = {.label = unit}};
  report::Series by_hand{.label = "rate set by hand", .colour = report::Colour::kOrange};
  report::Series ours{.label = "Catan", .line = report::Line::kNone, .colour = report::Colour::kBlue};
  report::Series predicted{.label = "predicted", .line = report::Line::kNone, .colour = report::Colour::kGreen};
  for (const Row& row : summary.rows) {
    if (row.cores != cores || row.speed != speed) continue;
    if (row.predicted_ms && value == &Row::response_ms) {
      predicted.points.push_back({.x = row.source_hz.median, .y = row.predicted_ms->median});
    }
    (row.scheduler == "catan" ? ours : by_hand).points.push_back(point_of(row, row.*value));
    if (row.scheduler == "catan") {
      panel.markers.push_back({.x = row.source_hz.median,
                               .label = fmt::format("Catan {:.1f} Hz", row.source_hz.median),
                               .colour = report::Colour::kBlue});
    } else if (row.scheduler == "default") {
      panel.markers.push_back(
          {.x = row.source_hz.median, .label = "default", .colour = report::Colour::kGrey, .dashed = true});
    }
  }
  std::ranges::sort(by_hand.points, {}, &report::Point::x);
  panel.series = {std::move(by_hand), std::move(ours)};
  if (!predicted.points.empty()) panel.series.push_back(std::move(predicted));
  return panel;
}

report::Figure figure_of(const Summary& summary, double speed, Spread Row::*value, const std::string& title,
                         const std::string& unit) {
  report::Figure figure{
      .title = title, .arrangement = report::Arrangement::kSideBySide, .width = 1000, .panel_height = 360};
  for (const std::size_t cores : core_counts(summary)) {
    figure.panels.push_back(panel_of(summary, cores, speed, value, unit));
  }
  if (figure.panels.size() == 1) figure.width = 640;
  return figure;
}

// "178 ms (default: 254 ms)", or nothing where one of them is missing.
std::string head_to_head(const Summary& summary, std::size_t cores, double speed) {
  const Row* ours = find_row(summary, cores, "catan", speed);
  const Row* theirs = find_row(summary, cores, "default", speed);
  if (ours == nullptr || theirs == nullptr) return {};
  return fmt::format("{:.0f} ms (default: {:.0f} ms)", ours->response_ms.median, theirs->response_ms.median);
}

report::Table claims_table(const Summary& summary) {
  report::Table table{.header = {"Cores", "Claim", "Measured", "Held"},
                      .caption =
                          "Clearly below: by 5 % or more, and Catan's slowest round was faster than the default's "
                          "fastest. The best rate set by hand is the best of all that were tried, the default's "
                          "among them."};
  for (const Claim& claim : summary.claims) {
    table.rows.push_back({std::to_string(claim.cores), claim.text, claim.measured, claim.held ? "yes" : "NO"});
  }
  return table;
}

report::Table rows_table(const Summary& summary) {
  report::Table table{.header = {"Cores", "Face", "Source", "Response time (ms)", "p95 (ms)", "Predicted (ms)",
                                 "Mean angle (deg)", "Lost (%)"},
                      .caption = "Median of the rounds, in brackets the least and the greatest."};
  for (const Row& row : summary.rows) {
    table.rows.push_back(
        {std::to_string(row.cores), fmt::format("{:.1f} rad/s", row.speed),
         row.scheduler == "catan" ? fmt::format("Catan ({:.1f} Hz)", row.source_hz.median) : scheduler_text(row),
         shown(row.response_ms, 1), fmt::format("{:.1f}", row.response_p95_ms.median),
         row.predicted_ms ? fmt::format("{:.1f}", row.predicted_ms->median) : std::string("-"), shown(row.angle_deg, 2),
         fmt::format("{:.1f}", 100.0 * row.lost_fraction.median)});
  }
  return table;
}

report::Table speeds_table(const Summary& summary) {
  report::Table table{.header = {"Cores", "Face", "Default: angle (deg)", "Catan: angle (deg)", "Default: lost (%)",
                                 "Catan: lost (%)"}};
  for (const Row& ours : summary.rows) {
    const Row* theirs = find_row(summary, ours.cores, "default", ours.speed);
    if (ours.scheduler != "catan" || theirs == nullptr) continue;
    table.rows.push_back({std::to_string(ours.cores), fmt::format("{:.1f} rad/s", ours.speed),
                          shown(theirs->angle_deg, 2), shown(ours.angle_deg, 2),
                          fmt::format("{:.1f}", 100.0 * theirs->lost_fraction.median),
                          fmt::format("{:.1f}", 100.0 * ours.lost_fraction.median)});
  }
  return table;
}

std::string disturbed_text(const Results& results) {
  return fmt::format(
      "Other programs used {:.0f} % of the CPUs while this was measured. Ordinary scheduling shares with them, so the "
      "default and the rates set by hand look worse here than on a quiet machine: measure again when it is quiet.",
      100.0 * median_others(results));
}

void add_notes(report::Page& page, const Results& results) {
  if (!results.no_real_time.empty()) {
    page.note("Rates only: " + results.no_real_time +
                  " Catan planned and triggered, but could not put its nodes before other threads; what follows was "
                  "measured so.",
              report::NoteKind::kWarning);
  }
  if (results.slowdown != 1.0) {
    page.note(
        fmt::format("Slowdown {}: every run of a node burned {} times its own CPU time more, to stand for a slower "
                    "board.",
                    results.slowdown, results.slowdown - 1.0));
  }
  if (median_others(results) > kDisturbed) page.note(disturbed_text(results), report::NoteKind::kWarning);
  if (!results.complete) {
    page.note("Stopped early: not all trials were run.", report::NoteKind::kWarning);
  }
  if (results.quick) {
    page.note("A quick run: one short round, which shows that all works and proves nothing.",
              report::NoteKind::kWarning);
  }
}

std::vector<std::pair<std::string, std::string>> headline(const Results& results, const Summary& summary) {
  std::vector<std::pair<std::string, std::string>> facts;
  for (const std::size_t cores : core_counts(summary)) {
    const std::string text = head_to_head(summary, cores, results.medium_speed);
    if (!text.empty()) facts.emplace_back("Response time on " + cores_text(cores), text);
  }
  const Compute compute = median_compute(results);
  facts.emplace_back("Compute time of camera, detect, plan",
                     fmt::format("{:.1f}, {:.1f}, {:.1f} ms", compute.camera, compute.detect, compute.plan));
  facts.emplace_back("CPU time used by others meanwhile", fmt::format("{:.1f} %", 100.0 * median_others(results)));
  facts.emplace_back("Slowdown", fmt::format("{}", results.slowdown));
  return facts;
}

void add_method(report::Page& page, const Results& results) {
  page.section("How it was measured")
      .paragraph(
          "The program face_tracking runs the same nodes under every scheduler. The camera node renders the view of a "
          "camera that stands in the middle of a square along which a face walks, now and then turning round; then it "
          "removes noise and the lens's distortion. The detect node looks for the face with a HAAR cascade; what "
          "counts "
          "is what it finds in the picture. The plan node estimates where the face goes and sets how fast the motor "
          "turns the camera, 3.2 rad/s at most. The faces come from a film, the street from photographs, all from "
          "Debian's opencv-doc.")
      .paragraph(
          "Response time: for two consecutive pictures that both reached the motor, from the beginning of the first to "
          "the end of the motor's run that used the second. It is the longest that a change in the world can wait for "
          "a "
          "reaction. Angle: between the camera's axis and the face, sampled every 2 ms. Lost: the face was outside the "
          "picture. Warming up (1.5 s) is left out for every scheduler.")
      .paragraph(
          "'default' is what the app's developer set by hand: a source of 30 Hz under ordinary Linux scheduling, "
          "however "
          "many cores there are. The other rates set by hand are ordinary scheduling too. Catan measured the nodes, "
          "computed the rate from what they cost, and ran them at real-time levels where the machine grants these.");
  page.paragraph(rounds_text(results))
      .paragraph("To measure it again: make demo. The numbers behind this page: results.json beside it.");
}

std::string number_in_words(std::size_t count) {
  constexpr std::array<const char*, 4> kWords{"no", "one", "two", "three"};
  return count < kWords.size() ? kWords[count] : std::to_string(count);
}

}  // namespace

std::string rounds_text(const Results& results) {
  std::set<int> rounds;
  std::set<int> with_sweep;
  double seconds = 0.0;
  for (const Measured& run : results.runs) {
    rounds.insert(run.trial.round);
    if (run.trial.scheduler.starts_with("rate:")) with_sweep.insert(run.trial.round);
    seconds = std::max(seconds, run.trial.seconds);
  }
  std::string text = fmt::format("{} trials of {:.1f} s at most in ", results.runs.size(), seconds);
  if (rounds.size() == 1) {
    text += "one round, in which all give the face the same walk.";
  } else {
    text += number_in_words(rounds.size()) + " interleaved rounds";
    if (!with_sweep.empty() && with_sweep.size() < rounds.size()) {
      text += ", rates set by hand in the first" +
              (with_sweep.size() == 1 ? " alone" : " " + number_in_words(with_sweep.size()));
    }
    text += "; all trials of a round give the face the same walk.";
  }
  if (!with_sweep.empty()) text += fmt::format(" The sweep was made at {:.1f} rad/s.", results.medium_speed);
  if (rounds.size() > 1) text += " Bars in the figures reach from the least to the greatest of the rounds.";
  return text;
}

report::Figure response_figure(const Summary& summary, double speed) {
  return figure_of(summary, speed, &Row::response_ms, "Response time against source rate", "Response time (ms)");
}

report::Figure angle_figure(const Summary& summary, double speed) {
  return figure_of(summary, speed, &Row::angle_deg, "Mean angle against source rate", "Mean angle (deg)");
}

Result<std::string> render_page(const Results& results, const std::optional<page::Glance>& glance) {
  const Summary summary = summarise(results);
  const Result<std::string> response = report::render_svg(response_figure(summary, results.medium_speed));
  if (!response) return response.error();
  const Result<std::string> angle = report::render_svg(angle_figure(summary, results.medium_speed));
  if (!angle) return angle.error();

  report::Page page("Face tracking under Catan",
                    "A camera turns after a face. How soon it reacts depends on how often pictures are taken and which "
                    "node runs when: set by hand for one board, or computed by Catan from what the nodes cost on this "
                    "one.");
  add_notes(page, results);
  page.facts(headline(results, summary));
  if (glance) {
    page.head(glance->head);
    page.section("The app, and who had the cores").element(glance->body);
    page.element(
        fmt::format("<p>One run under Catan. <a href=\"{}\">This run beside one under the default</a>: "
                    "timelines to move and zoom, distributions, why responses were late.</p>",
                    kLookPage));
  }
  page.section("What is claimed, and whether it held").table(claims_table(summary));
  page.section("Response time")
      .figure(*response,
              "Lower is better. Too low a source rate leaves the cores idle; too high a one makes pictures "
              "wait for one another. Catan computes the rate instead of having it tried out.");
  page.section("How well the face is followed")
      .figure(*angle, "Lower is better: the mean angle between the camera's axis and the face.")
      .table(speeds_table(summary));
  page.section("All numbers").table(rows_table(summary));
  add_method(page, results);
  page.section("The machine").table(experiments::table_of(results.host));
  return page.html();
}

std::string to_text(const Results& results) {
  const Summary summary = summarise(results);
  std::string text = fmt::format("\n{:<5} {:<9} {:<16} {:>9} {:>13} {:>9} {:>11} {:>7}\n", "cores", "rad/s",
                                 "scheduler", "source Hz", "response ms", "predicted", "angle deg", "lost %");
  for (const Row& row : summary.rows) {
    text += fmt::format("{:<5} {:<9.1f} {:<16} {:>9.1f} {:>13.1f} {:>9} {:>11.2f} {:>7.1f}\n", row.cores, row.speed,
                        scheduler_text(row), row.source_hz.median, row.response_ms.median,
                        row.predicted_ms ? fmt::format("{:.1f}", row.predicted_ms->median) : "-", row.angle_deg.median,
                        100.0 * row.lost_fraction.median);
  }
  text += fmt::format("medians over rounds; slowdown {}\n\n", results.slowdown);
  for (const Claim& claim : summary.claims) {
    text += fmt::format("{:<4} {}: {}: {}\n", claim.held ? "held" : "NOT", cores_text(claim.cores), claim.text,
                        claim.measured);
  }
  if (median_others(results) > kDisturbed) text += "\n" + disturbed_text(results) + "\n";
  if (!results.no_real_time.empty()) text += "\nrates only: " + results.no_real_time + "\n";
  return text;
}

}  // namespace ctn::demo
