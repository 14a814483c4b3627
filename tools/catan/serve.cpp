// catan serve: schedules an app whose nodes are other processes'.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "command.h"
#include "config/app_file.h"
#include "http_options.h"
#include "os/linux/tcp.h"
#include "scheduling_options.h"
#include "serving.h"
#include "status_line.h"
#include "watch.h"

namespace ctn::tool {
namespace {

struct ServeOptions {
  std::string app;
  std::string socket;
  std::vector<std::string> users;
  HttpOptions http;
  SchedulingOptions scheduling;
  WatchedApp watched;
};

int serve_app(const ServeOptions& options) {
  ServingOptions serving;
  if (!options.http.address.empty()) {
    if (const auto address = os::parse_tcp_address(options.http.address); !address) {
      return report_error(address.error());
    }
    serving.companion = [&options](const std::string& socket) { return options.http.command_line(socket); };
  }
  auto file = config::load_app_file(options.app);
  if (!file) return report_error(file.error());
  auto scheduler = options.scheduling.for_scheduler(file->app, options.scheduling.record);
  if (!scheduler) return report_error(scheduler.error());
  serving.scheduler = std::move(*scheduler);
  const StatusLine status;
  serving.scheduler.on_notice = [&status](const std::string& text) {
    status.show({});
    note(text);
  };
  const int flight_recorder_mib = options.scheduling.flight_recorder_mib;
  if (Status fits = options.watched.check(file->app, flight_recorder_mib); !fits) return report_error(fits.error());
  if (flight_recorder_mib > 0) serving.watched = options.watched;
  serving.socket = options.socket;
  serving.users = options.users;
  if (status.shown()) {
    serving.on_progress = [&](const Snapshot& snapshot, double measured) {
      status.show(status_text(snapshot, measured, std::nullopt));
    };
  }
  const auto served = serve(std::move(*file), serving);
  return served ? kSuccess : report_error(served.error());
}

}  // namespace

void add_serve_command(CLI::App& cli, int& exit_code) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = cli.add_subcommand("serve", "Schedule an app whose nodes are programs of their own");
  command->footer(
      "Examples:\n"
      "  sudo catan serve app.yaml                        programs register at /run/catan/APP.sock\n"
      "  catan serve app.yaml --socket /tmp/app.sock      and start them with CATAN_SOCKET=/tmp/app.sock\n"
      "  sudo catan serve app.yaml --allow-user 1000      a user whose programs may register, beside root\n"
      "  catan serve app.yaml --on-late 'scan -> LP>150'  saves the last seconds when that takes more than 150 ms\n"
      "  catan serve app.yaml --http 8080                 and a page at http://127.0.0.1:8080/ (docs/http.md)\n"
      "  catan node app.yaml camera --synthetic costs.yaml    a program that plays one node\n"
      "It serves until it is told to end (Ctrl-C, SIGTERM). If it is killed, a guardian gives all threads their "
      "scheduling back, and\nnodes go on at the rates that were planned last until there is a server again; its last "
      "seconds are saved as a\nrecord, APP-killed-TIME.catan. "
      "docs/many-processes.md says more.\n"
      "Exit code: 0 it was told to end, 1 failure at run time, 2 a mistake in a file or on the command line.");
  command->add_option("APP", options->app, "App file (docs/app-file.md)")->required();
  command->add_option("--socket", options->socket, "Where programs register, instead of the usual path")
      ->type_name("PATH");
  command
      ->add_option("--allow-user", options->users,
                   "Number of a user whose programs may register, beside root, the own user and who ran sudo")
      ->type_name("UID");
  CLI::Option* http = command
                          ->add_option("--http", options->http.address,
                                       "Port or ADDRESS:PORT of a page, and of metrics for Prometheus: starts catan "
                                       "http")
                          ->type_name("ADDRESS");
  options->http.add_control_to(*command, http);
  options->scheduling.add_to(*command);
  options->watched.add_to(*command);
  command->callback([options, &exit_code] { exit_code = serve_app(*options); });
}

}  // namespace ctn::tool
