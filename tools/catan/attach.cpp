#include "attach.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "config/app_file.h"
#include "flight/find.h"
#include "os/linux/descriptor.h"
#include "runtime/socket_path.h"

namespace ctn::tool {
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

// What flight::find() takes: the app's name where the target is an app file, else the target itself.
Result<std::string> name_to_find(const std::string& target) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(target, unknown)) return target;
  const Result<graph::App> app = config::load_app(target);
  if (!app) return app.error();
  return app->name;
}

runtime::ServerAddress address_of_app(const std::string& app) {
  return {.sockets = runtime::sockets_of_app(app), .app = app};
}

}  // namespace

Result<runtime::ServerAddress> address_of(const std::string& server) {
  std::error_code unknown;
  const std::filesystem::file_status status = std::filesystem::status(server, unknown);
  if (std::filesystem::is_socket(status)) return runtime::ServerAddress{.sockets = {server}};
  if (std::filesystem::is_regular_file(status)) {
    const Result<graph::App> app = config::load_app(server);
    if (!app) return app.error();
    return address_of_app(app->name);
  }
  // The name of an app may have a slash in it.
  const bool is_path =
      server.starts_with('/') || server.starts_with('.') || server.ends_with(".yaml") || server.ends_with(".sock");
  if (!is_path) return address_of_app(server);
  return Error::environment(fmt::format("no server answers at {}: there is no such file", printable(server)),
                            "name the server's socket, its app file, or the app");
}

// Asks the server first: through its socket it gives the memory to every user who may control it, while /proc takes the
// right to trace its process.
Result<flight::Recording> attach(os::Clock& clock, const std::string& target) {
  if (!target.empty() && !is_number(target)) {
    const Result<runtime::ServerAddress> server = address_of(target);
    if (!server) return server.error();
    const bool listens = std::any_of(server->sockets.begin(), server->sockets.end(),
                                     [](const std::string& path) { return std::filesystem::exists(path); });
    if (listens) {
      Result<os::Descriptor> memory = runtime::ask_for_flight(clock, *server);
      // The socket may be left over from a server that was killed, while a session runs the same app.
      if (memory) return flight::Recording::open(std::move(*memory));
      if (std::filesystem::is_socket(target) || memory.error().kind() == ErrorKind::kCaller) return memory.error();
    }
  }
  const Result<std::string> name = name_to_find(target);
  if (!name) return name.error();
  Result<os::Descriptor> memory = flight::find(*name);
  if (!memory) return memory.error();
  return flight::Recording::open(std::move(*memory));
}

void keep_off_scheduled_cpus(os::Os& os, const os::CpuSet& scheduled) {
  const auto online = os.online_cpus();
  if (!online) return;
  std::vector<int> others;
  for (const int cpu : online->cpus()) {
    if (!scheduled.contains(cpu)) others.push_back(cpu);
  }
  if (!others.empty()) static_cast<void>(os.set_affinity(os.current_thread(), os::CpuSet(std::move(others))));
}

}  // namespace ctn::tool
