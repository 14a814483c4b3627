#include "runtime/socket_path.h"

#include <fmt/format.h>

#include <cstdlib>

#include "base/text.h"
#include "os/linux/process.h"

namespace ctn::runtime {
namespace {

constexpr const char* kSystemFolder = "/run/catan";

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::string in_system_folder(const std::string& app) {
  return fmt::format("{}/{}.sock", kSystemFolder, as_file_name(app));
}

std::string in_own_folder(const std::string& app) {
  const std::string folder = variable("XDG_RUNTIME_DIR");
  return folder.empty() ? "" : fmt::format("{}/catan/{}.sock", folder, as_file_name(app));
}

std::vector<std::string> usual_sockets(const std::string& app) {
  std::vector<std::string> paths;
  if (std::string own = in_own_folder(app); !own.empty()) paths.push_back(std::move(own));
  paths.push_back(in_system_folder(app));
  return paths;
}

}  // namespace

Result<std::string> socket_to_serve(const std::string& app) {
  if (std::string named = variable(kSocketVariable); !named.empty()) return named;
  if (os::current_user() == 0) return in_system_folder(app);
  std::string own = in_own_folder(app);
  if (!own.empty()) return own;
  return Error::caller("there is no folder for the server's socket: XDG_RUNTIME_DIR is not set",
                       "name a path: --socket PATH");
}

Result<std::vector<std::string>> sockets_to_try(const std::string& app) {
  if (const std::string named = variable(kSocketVariable); !named.empty()) return std::vector{named};
  if (app.empty()) {
    return Error::caller(fmt::format("no server is named: {} is not set", kSocketVariable),
                         fmt::format("set {} to the server's socket, or name the app in the options", kSocketVariable));
  }
  return usual_sockets(app);
}

std::vector<std::string> sockets_of_app(const std::string& app) {
  std::vector<std::string> paths = usual_sockets(app);
  if (std::string named = variable(kSocketVariable); !named.empty()) paths.insert(paths.begin(), std::move(named));
  return paths;
}

}  // namespace ctn::runtime
