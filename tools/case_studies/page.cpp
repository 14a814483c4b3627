#include "page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "comparison.h"
#include "experiments/host.h"
#include "report/html.h"
#include "report/plot.h"
#include "report/table.h"

namespace ctn::case_studies {
namespace {

struct Count {
  std::size_t there = 0;
  std::size_t wanted = 0;

  Count& operator+=(const Count& other) {
    there += other.there;
    wanted += other.wanted;
    return *this;
  }
};

std::size_t runs_there(const Runs& runs, const std::string& batch) {
  const auto found = runs.find(batch);
  return found == runs.end() ? 0 : found->second.size();
}

Count count_of(const StudyResults& results) {
  Count count;
  if (!results.study.missing.empty()) return count;
  for (const Batch& batch : results.study.batches) {
    count += {runs_there(results.runs, batch.name), static_cast<std::size_t>(batch.runs)};
  }
  return count;
}

Count count_of(const Results& results) {
  Count count;
  for (const StudyResults& study : results.studies) count += count_of(study);
  return count;
}

bool tells_something(const StudyResults& results) {
  return results.study.missing.empty() && is_complete_enough(results.study, results.runs);
}

// Of all studies that tell something, with the study's title.
std::vector<std::pair<std::string, Claim>> claims_of(const Results& results) {
  std::vector<std::pair<std::string, Claim>> claims;
  for (const StudyResults& one : results.studies) {
    if (!tells_something(one)) continue;
    for (Claim& claim : one.study.claim(one.study, one.runs)) claims.emplace_back(one.study.title, std::move(claim));
  }
  return claims;
}

std::string verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::kHeld:
      return "yes";
    case Verdict::kNotShown:
      return "not shown";
    case Verdict::kFailed:
      break;
  }
  return "NO";
}

std::string value_text(double value, int digits) {
  return std::isinf(value) ? "never" : fmt::format("{:.{}f}", value, digits);
}

std::string result_text(const Row& row) {
  if (row.runs == 0) return "-";
  if (row.metric->method == Method::kShares) return fmt::format("{} of {}", row.share.count, row.share.total);
  return value_text(row.spread->median, row.metric->digits);
}

std::string spread_text(const Row& row) {
  if (row.runs == 0) return "-";
  if (row.metric->method == Method::kShares) {
    const Interval interval = wilson(row.share);
    return fmt::format("{:.0f} to {:.0f} %", 100.0 * interval.low, 100.0 * interval.high);
  }
  const std::string low = value_text(row.spread->lower_quartile, row.metric->digits);
  const std::string high = value_text(row.spread->upper_quartile, row.metric->digits);
  return low == high ? low : fmt::format("{} to {}", low, high);
}

std::string mean_text(const Row& row) {
  if (!row.spread || std::isinf(row.spread->mean)) return "-";
  return fmt::format("{:.{}f} \u00b1 {:.{}f}", row.spread->mean, row.metric->digits, row.spread->deviation,
                     row.metric->digits);
}

std::string comparison_text(const Row& row) {
  if (!row.probability) return "";
  if (!row.significant()) return "not shown";
  if (row.better()) return "better";
  if (row.worse()) return "worse";
  return row.sign > 0 ? "larger" : "smaller";
}

report::Table table_of(const StudyResults& results, const std::vector<Row>& rows) {
  report::Table table{
      .header = {"Figure", "Under", "Runs", "Result", "Spread", "Mean and deviation", "Difference", "p"}};
  std::vector<std::string> references;
  for (const Batch& batch : results.study.batches) {
    if (batch.reference) references.push_back(batch.label);
  }
  table.caption = fmt::format("Difference from: {}. {}", fmt::join(references, "; "),
                              references.size() > 1 ? "Each is compared with that of its own kind." : "");
  const Metric* before = nullptr;
  for (const Row& row : rows) {
    table.rows.push_back({row.metric == before ? "" : row.metric->name, row.batch->label, std::to_string(row.runs),
                          result_text(row), spread_text(row), mean_text(row), comparison_text(row),
                          row.probability ? probability_text(*row.probability) : ""});
    before = row.metric;
  }
  return table;
}

// Where a batch is better than its reference by more than chance.
report::Table better_elsewhere(const Results& results) {
  report::Table table{.header = {"Study", "Figure", "Better", "Its result", "The reference's", "p"}};
  for (const StudyResults& one : results.studies) {
    if (!tells_something(one)) continue;
    const std::vector<Row> rows = compare(one.study, one.runs);
    for (const Row& row : rows) {
      if (!row.better()) continue;
      const auto reference = std::ranges::find_if(rows, [&](const Row& other) {
        return other.metric == row.metric && other.batch->reference && other.batch->group == row.batch->group;
      });
      table.rows.push_back({one.study.title, row.metric->name, row.batch->label, result_text(row),
                            result_text(*reference), probability_text(*row.probability)});
    }
  }
  return table;
}

report::Table claims_table(const Results& results) {
  report::Table table{
      .header = {"Study", "Expected", "Measured", "p", "Held"},
      .caption =
          "Measured: Catan's first. p: how likely such a difference is where there is none, adjusted for "
          "several comparisons. Not shown: it came out as expected, but chance may have done it (p of "
          "0.05 and more), or so few runs are there that no difference could show."};
  std::string before;
  for (const auto& [study, claim] : claims_of(results)) {
    table.rows.push_back({study == before ? "" : study, claim.text, claim.measured,
                          claim.probability ? probability_text(*claim.probability) : "", verdict_text(claim.verdict)});
    before = study;
  }
  return table;
}

void add_notes(report::Page& page, const Results& results) {
  if (results.quick) {
    page.note("A quick run: few runs, and short ones, which show that all works and prove little.",
              report::NoteKind::kWarning);
  }
  const Count count = count_of(results);
  if (count.there < count.wanted) {
    page.note(fmt::format("Not all runs are there: {} of {}. To go on, run it again.", count.there, count.wanted),
              report::NoteKind::kWarning);
  }
  if (!results.failed.empty()) {
    page.note(fmt::format("Failed: {}.", fmt::join(results.failed, "; ")), report::NoteKind::kWarning);
  }
  for (const std::string& runs : results.left_out) page.note(runs + ".", report::NoteKind::kWarning);
  for (const StudyResults& one : results.studies) {
    if (!one.study.missing.empty()) page.note(fmt::format("{}: left out. {}", one.study.title, one.study.missing));
  }
}

std::string summary_of(const Results& results) {
  const auto claims = claims_of(results);
  const auto number = [&](Verdict verdict) {
    return std::ranges::count_if(claims, [&](const auto& entry) { return entry.second.verdict == verdict; });
  };
  return fmt::format("{} held, {} not shown, {} did not hold", number(Verdict::kHeld), number(Verdict::kNotShown),
                     number(Verdict::kFailed));
}

Status add_study(report::Page& page, const StudyResults& results) {
  const Study& study = results.study;
  page.section(study.title, study.id).paragraph(study.text);
  if (!study.missing.empty()) {
    page.note("Left out. " + study.missing, report::NoteKind::kWarning);
    return Done{};
  }
  if (!is_complete_enough(study, results.runs)) {
    page.note("Too few runs are there yet.", report::NoteKind::kWarning);
    return Done{};
  }
  if (study.draw) {
    for (const Drawn& drawn : study.draw(study, results.runs)) {
      const Result<std::string> svg = report::render_svg(drawn.figure);
      if (!svg) return svg.error();
      page.figure(*svg, drawn.caption);
    }
  }
  page.table(table_of(results, compare(study, results.runs)));
  return Done{};
}

void add_method(report::Page& page, const Results& results) {
  page.section("How to read this")
      .paragraph(
          "In virtual time the nodes really compute, in a simulated world, and a run of a node costs what its work was "
          "worth; the same bytes come out each time. Each scheduler has the same seeds, so the same worlds, noise and "
          "drift.")
      .paragraph(
          "Result: the median of the runs, or how many of them. Spread: the quartiles, or the 95 % interval of the "
          "share (Wilson's). 'Never': it had not come to that when the run ended, which counts as later than all "
          "others. Deviation: the standard deviation of the runs.")
      .paragraph(
          "Tests are exact and two-sided: Fisher's for shares; Mann and Whitney's for figures of runs; Wilcoxon's "
          "signed rank test where runs of one seed are of one world. Within a table, the probabilities of one figure "
          "are adjusted by Holm's method. Better or worse is what has a p below 0.05.")
      .paragraph(
          fmt::format("Seeds from {} on. To run it again: make case-studies. The runs behind this page are beside "
                      "it, a file each.",
                      results.seed));
}

}  // namespace

Result<std::string> render_page(const Results& results) {
  report::Page page(
      "Case studies of Catan",
      "Real work in simulated worlds: the paper's experiments with a robot and a headset, repeated under Catan, "
      "under rates set by hand, and under other methods.");
  add_notes(page, results);
  const Count count = count_of(results);
  page.facts(
      {{"Runs", fmt::format("{} of {}", count.there, count.wanted)}, {"What was expected", summary_of(results)}});
  page.section("What was expected, and what came out").table(claims_table(results));
  page.section("Where another scheduler does better than Catan");
  if (const report::Table better = better_elsewhere(results); better.rows.empty()) {
    page.paragraph("Nowhere by more than chance, in the figures below.");
  } else {
    page.table(better);
  }
  if (!results.maps.empty()) {
    page.section("The maps (figure 7)");
    for (const Map& map : results.maps) page.figure(map.svg, map.name);
  }
  for (const StudyResults& one : results.studies) {
    if (Status added = add_study(page, one); !added) return added.error();
  }
  add_method(page, results);
  page.section("The machine").table(experiments::table_of(results.host));
  return page.html();
}

std::string to_text(const Results& results) {
  const Count count = count_of(results);
  std::string text = fmt::format("{} of {} runs; {}\n", count.there, count.wanted, summary_of(results));
  std::string before;
  for (const auto& [study, claim] : claims_of(results)) {
    if (study != before) text += fmt::format("\n{}\n", study);
    before = study;
    text += fmt::format("{:<9}  {}: {}{}\n", verdict_text(claim.verdict), claim.text, claim.measured,
                        claim.probability ? fmt::format(" (p {})", probability_text(*claim.probability)) : "");
  }
  for (const std::string& runs : results.left_out) text += fmt::format("\nNOT USED   {}\n", runs);
  for (const StudyResults& one : results.studies) {
    if (!one.study.missing.empty()) text += fmt::format("\nleft out   {}: {}\n", one.study.title, one.study.missing);
  }
  if (const report::Table better = better_elsewhere(results); !better.rows.empty()) {
    text += "\nbetter than the reference, by more than chance:\n" + report::to_text(better);
  }
  return text;
}

}  // namespace ctn::case_studies
