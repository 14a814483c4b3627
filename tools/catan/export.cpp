// catan export: writes a record for the tools that people already use.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "command.h"
#include "export/csv.h"
#include "export/output.h"
#include "export/perfetto.h"
#include "os/linux/whole_file.h"
#include "record/reader.h"
#include "status_line.h"

namespace ctn::tool {
namespace {

struct ExportOptions {
  std::string record;
  std::string format;
  std::string table;
  std::string output;
};

using Export = std::function<Status(const exports::Sink&)>;

Status to_stdout(const Export& write) {
  return write([](std::string_view bytes) -> Status {
    print(bytes);
    return Done{};
  });
}

// Writes all of these files or none.
Status to_files(const std::vector<std::pair<std::string, Export>>& exports) {
  std::vector<std::unique_ptr<os::WholeFile>> files;
  for (const auto& [path, write] : exports) {
    auto file = os::WholeFile::create(path, os::WholeFile::Existing::kStays);
    if (!file) return file.error();
    files.push_back(std::move(*file));
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    os::WholeFile& file = *files[i];
    if (Status done = exports[i].second([&](std::string_view bytes) { return file.write(bytes); }); !done) return done;
  }
  return os::WholeFile::finish(files);
}

Status export_tables(const record::Reader& record, const std::string& folder, ProgressLine& progress) {
  std::error_code failed;
  std::filesystem::create_directory(folder, failed);
  if (failed || !std::filesystem::is_directory(folder, failed)) {
    return Error::caller(fmt::format("{} is not a folder, and cannot be made", folder), "name a folder for the tables");
  }
  std::vector<std::pair<std::string, Export>> exports;
  const auto tables = exports::csv_tables();
  for (std::size_t i = 0; i < tables.size(); ++i) {
    exports.emplace_back(fmt::format("{}/{}.csv", folder, tables[i]), [&, i](const exports::Sink& sink) {
      return exports::write_csv(record, tables[i], sink, [&, i](double part) {
        progress.show((static_cast<double>(i) + part) / static_cast<double>(tables.size()));
      });
    });
  }
  return to_files(exports);
}

Status check(const ExportOptions& options) {
  const bool csv = options.format == "csv";
  if (!csv && !options.table.empty()) {
    return Error::caller("--table is for CSV: a trace has no tables", "leave it out, or take --format csv");
  }
  if (csv && options.table.empty() && options.output.empty()) {
    return Error::caller("a record has several tables",
                         "name a folder for them with --output, or one of them with --table");
  }
  if (!csv && options.output.empty() && isatty(STDOUT_FILENO) == 1) {
    return Error::caller("a trace is not text for a terminal", "name a file for it with --output");
  }
  return Done{};
}

Status export_record(const ExportOptions& options) {
  if (Status done = check(options); !done) return done;
  const auto record = record::Reader::open(options.record);
  if (!record) return record.error();
  ProgressLine progress("exported");
  const bool csv = options.format == "csv";
  if (csv && options.table.empty()) return export_tables(*record, options.output, progress);
  const Export write = [&](const exports::Sink& sink) {
    const exports::Progress show = [&](double part) { progress.show(part); };
    return csv ? exports::write_csv(*record, options.table, sink, show) : exports::write_perfetto(*record, sink, show);
  };
  return options.output.empty() ? to_stdout(write) : to_files({{options.output, write}});
}

int run_export(const ExportOptions& options) {
  const Status done = export_record(options);
  return done ? kSuccess : report_error(done.error());
}

}  // namespace

void add_export_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = cli.add_subcommand("export", "Write a record as a trace for Perfetto, or as CSV");
  command->footer(
      "Examples:\n"
      "  catan export run.catan --format perfetto --output run.pftrace   open it in Perfetto's UI\n"
      "  catan export run.catan --format csv --output tables             a folder, one file a table\n"
      "  catan export run.catan --format csv --table runs > runs.csv     one table\n"
      "What is in them: docs/export.md. The record itself is an SQLite database: docs/record-schema.md.\n"
      "Exit code: 0 it was written, 1 failure at run time, 2 no such record, or a mistake on the command line.");
  command->add_option("RECORD", options->record, "Record that catan run --record made")->required();
  command->add_option("--format", options->format, "What to write")
      ->required()
      ->check(CLI::IsMember({"perfetto", "csv"}));
  const auto tables = exports::csv_tables();
  command->add_option("--table", options->table, "With CSV: write this table alone")
      ->check(CLI::IsMember(std::vector<std::string>(tables.begin(), tables.end())));
  command->add_option("--output", options->output,
                      "File to write instead of stdout; for several tables, the folder. No file is overwritten, and "
                      "none is there before it is whole");
  command->callback([options, &exit_code] { exit_code = run_export(*options); });
}

}  // namespace ctn::tool
