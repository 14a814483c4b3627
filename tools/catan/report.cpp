// catan report: what a run came to, from its record.
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "command.h"
#include "record/reader.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/page.h"
#include "report/text.h"

namespace ctn::tool {
namespace {

struct ReportOptions {
  std::string record;
  bool json = false;
  bool html = false;
  bool all = false;
};

int report(const ReportOptions& options) {
  const auto record = record::Reader::open(options.record);
  if (!record) return report_error(record.error());
  const auto metrics = report::measure(*record, options.all);
  if (!metrics) return report_error(metrics.error());
  print(options.json   ? report::to_json(*metrics)
        : options.html ? report::to_html(*metrics)
                       : report::to_text(*metrics));
  return kSuccess;
}

}  // namespace

void add_report_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = cli.add_subcommand("report", "Show what a recorded run came to, predicted beside measured");
  command->footer(
      "Examples:\n"
      "  catan report run.catan                    chains, nodes, triggers\n"
      "  catan report run.catan --html > run.html  the same as a page\n"
      "  catan report run.catan --json             for programs (docs/report-schema.md)\n"
      "The record itself is an SQLite database: docs/record-schema.md.");
  command->add_option("RECORD", options->record, "Record that catan run --record made")->required();
  CLI::Option* json = command->add_flag("--json", options->json, "Print one JSON document");
  command->add_flag("--html", options->html, "Print an HTML page")->excludes(json);
  command->add_flag("--all", options->all, "Include the warm-up");
  command->callback([options, &exit_code] { exit_code = report(*options); });
}

}  // namespace ctn::tool
