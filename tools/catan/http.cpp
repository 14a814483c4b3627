// catan http: serves a page of an app while it runs, and metrics for Prometheus.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "attach.h"
#include "base/text.h"
#include "command.h"
#include "http_options.h"
#include "live_source.h"
#include "os/linux/background.h"
#include "os/linux/linux_os.h"
#include "os/linux/signal_watch.h"
#include "os/linux/tcp.h"
#include "web/access.h"
#include "web/server.h"

namespace ctn::tool {
namespace {

constexpr std::uint64_t kMaxFiles = 256;
constexpr std::uint64_t kMaxMemory = std::uint64_t{1} << 30U;
constexpr std::size_t kTokenBytes = 16;

struct HttpCommand {
  std::string target;
  HttpOptions options;
  std::int32_t parent = 0;  // the process that started it, with which it ends; 0: started by a user
};

Result<std::string> read_token(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(4096, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  if (text.empty()) {
    return Error::caller(fmt::format("no token can be read from {}", quote(path)),
                         "name a file that has one, and that you may read");
  }
  auto token = web::token_from(text);
  if (!token) return token.error();
  std::error_code unknown;
  const auto others = std::filesystem::perms::group_read | std::filesystem::perms::others_read;
  if ((std::filesystem::status(path, unknown).permissions() & others) != std::filesystem::perms::none) {
    note(fmt::format("other users may read the token in {}; see `chmod 600`", quote(path)));
  }
  return token;
}

// The token that control needs; none: nothing can be changed.
Result<std::optional<std::string>> token_of(const HttpOptions& options) {
  if (!options.allow_control) return std::optional<std::string>();
  Result<std::string> token =
      options.token_file.empty() ? os::random_digits(kTokenBytes) : read_token(options.token_file);
  if (!token) return token.error();
  return std::optional(std::move(*token));
}

void tell(const web::Server& server, const HttpOptions& options, const std::optional<std::string>& token) {
  note(fmt::format("the page is at http://{}/", os::to_string(server.address())));
  if (!os::is_loopback_host(server.address().host)) {
    note("every client that reaches this address can look, and nothing is encrypted");
  }
  if (token && options.token_file.empty()) note(fmt::format("the token with which it can be changed: {}", *token));
}

Status serve_page(const HttpCommand& command) {
  outlive_readers();
  const auto address = os::parse_tcp_address(command.options.address);
  if (!address) return address.error();
  const auto token = token_of(command.options);
  if (!token) return token.error();
  if (command.parent != 0 && !os::end_with(os::ProcessId{command.parent})) return Done{};
  auto signals = os::SignalWatch::start({SIGINT, SIGTERM, SIGHUP});
  if (!signals) return signals.error();
  os::yield_to_others();
  os::limit_resources(kMaxFiles, kMaxMemory);
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  LiveSource source(*os, command.target);
  // A server that starts this process may not listen yet, so that not finding it is no error.
  if (const Status found = source.look(); !found && command.parent == 0) return found;
  const auto scheduled = command.options.cpus.empty() ? source.cpus() : command.options.scheduled();
  if (scheduled) keep_off_scheduled_cpus(*os, *scheduled);
  auto server = web::Server::open(*os, source, *address, *token);
  if (!server) return server.error();
  if (Status watched = (*server)->watch(signals->descriptor(),
                                        [&] {
                                          if (signals->next()) (*server)->stop();
                                        });
      !watched) {
    return watched;
  }
  tell(**server, command.options, *token);
  (*server)->run();
  return Done{};
}

}  // namespace

void add_http_command(CLI::App& cli, int& exit_code) {
  auto command = std::make_shared<HttpCommand>();
  command->options.address = kDefaultHttpAddress;
  CLI::App* sub = cli.add_subcommand("http", "Serve a page of an app while it runs, and metrics for Prometheus");
  sub->footer(
      "Examples:\n"
      "  catan http                             the only app that Catan schedules here, at http://127.0.0.1:8080/\n"
      "  catan http robot --listen 9000         a server by the name of its app, its app file or its socket\n"
      "  catan http robot --allow-control       prints a token, with which weights and bounds can be changed\n"
      "  catan http robot --listen [::]:8080    for other machines, too: all that reach it can look\n"
      "  catan serve app.yaml --http 8080       starts this beside the server, and ends it with it\n"
      "It runs as a process of its own, at the ordinary level, on CPUs that no node may use where there are any: what\n"
      "clients do does not reach the scheduler. docs/http.md lists pages and metrics. POST /whatif says what would be\n"
      "planned with other weights, bounds, costs or cores.\n"
      "Exit code: 0 it was told to end, 1 failure at run time, as where the address is in use,\n"
      "2 no such app runs, or a mistake.");
  sub->add_option("TARGET", command->target,
                  "A server's socket, an app file, the name of an app, or the number of a process");
  sub->add_option("--listen", command->options.address, "Port, ADDRESS:PORT or [IPv6]:PORT; port 0: one that is free")
      ->capture_default_str();
  command->options.add_control_to(*sub);
  sub->add_option("--parent", command->parent)->group("");
  sub->add_option("--scheduled-cpus", command->options.cpus)->group("");
  sub->callback([command, &exit_code] {
    const Status done = serve_page(*command);
    exit_code = done ? kSuccess : report_error(done.error());
  });
}

}  // namespace ctn::tool
