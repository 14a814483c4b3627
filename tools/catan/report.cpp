// catan report: shows the results of a run from its record.
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>

#include "command.h"
#include "page/page.h"
#include "record/reader.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/text.h"
#include "report_page.h"
#include "status_line.h"
#include "why/json.h"
#include "why/why.h"
#include "why_text.h"

namespace ctn::tool {
namespace {

struct ReportOptions {
  std::string record;
  bool json = false;
  bool html = false;
  std::string page;     // with html: the file; empty: stdout
  std::string compare;  // with html: another record; empty: none
  bool all = false;
  std::string why;  // a chain
  std::size_t worst = 5;
};

Result<std::string> why_late(const record::Reader& record, const ReportOptions& options) {
  const auto term = why::find_chain(record.app(), options.why);
  if (!term) return term.error();
  const auto analysis = why::analyse(record, *term, {.worst = options.worst, .whole = options.all});
  if (!analysis) return analysis.error();
  const TimePoint started = record.header().started;
  return options.json ? why::to_json(*analysis, record.app(), started) : why_text(*analysis, record.app(), started);
}

Result<std::string> results(const record::Reader& record, const ReportOptions& options) {
  if (!options.why.empty()) return why_late(record, options);
  if (options.html) return report_page(record, options.record, options.compare, options.all);
  const auto metrics = report::measure(record, {.whole = options.all, .worst = 0});
  if (!metrics) return metrics.error();
  return options.json ? report::to_json(*metrics) : report::to_text(*metrics);
}

int report(const ReportOptions& options) {
  auto record = record::Reader::open(options.record);
  if (!record) return report_error(record.error());
  ProgressLine progress("read");
  record->on_progress([&progress](std::uint64_t events) { progress.show_count(events); });
  const auto text = results(*record, options);
  progress.end();
  if (!text) return report_error(text.error());
  if (options.page.empty()) {
    print(*text);
    return kSuccess;
  }
  const Status saved = page::save(*text, options.page);
  return saved ? kSuccess : report_error(saved.error());
}

}  // namespace

void add_report_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = cli.add_subcommand("report", "Show what a recorded run came to, predicted beside measured");
  command->footer(
      "Examples:\n"
      "  catan report run.catan                    chains, nodes, triggers\n"
      "  catan report run.catan --html run.html    a page: timelines, distributions, figures\n"
      "  catan report new.catan --html both.html --compare old.catan\n"
      "  catan report run.catan --json             for programs (docs/report-schema.md)\n"
      "  catan report run.catan --why LP           why the chain that ends at LP was late, and its worst responses\n"
      "  catan report run.catan --why 'scan > LM > LP' --worst 20 --json\n"
      "The record itself is an SQLite database: docs/record-schema.md.\n"
      "Exit code: 0 it was shown, 1 failure at run time, 2 no such record, or a mistake on the command line.");
  command->add_option("RECORD", options->record, "Record that catan run --record made");
  CLI::Option* json = command->add_flag("--json", options->json, "Print one JSON document");
  CLI::Option* html = command->add_option("--html", options->page, "Write an HTML page to FILE; without it, to stdout")
                          ->type_name("FILE")
                          ->expected(0, 1)
                          ->excludes(json);
  command->add_option("--compare", options->compare, "Show the run of this record beside it on the page")
      ->type_name("OTHER")
      ->needs(html);
  command->add_flag("--all", options->all, "Include the warm-up");
  CLI::Option* why =
      command
          ->add_option("--why", options->why,
                       "Take the longest response times of a chain apart, and count what made responses late "
                       "(docs/why.md). A chain is a response_time of the objective: its number there, its path, or its "
                       "last node")
          ->type_name("CHAIN")
          ->excludes(html);
  command->add_option("--worst", options->worst, "With --why: how many responses to take apart")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str()
      ->needs(why);
  command->callback([options, html, &exit_code] {
    options->html = html->count() > 0;
    if (options->record.empty()) std::swap(options->record, options->page);  // --html RECORD
    if (options->record.empty()) throw CLI::RequiredError("RECORD");
    exit_code = report(*options);
  });
}

}  // namespace ctn::tool
