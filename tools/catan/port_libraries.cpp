#include "port_libraries.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

namespace ctn::tool {
namespace {

constexpr const char* kPreloadVariable = "LD_PRELOAD";

// `built` is the folder in a build, `without` what this Catan was built without, where the library is not there.
Result<std::string> find_library(const char* library, const char* built, const char* without, const char* hint) {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path();
  for (const char* const place : {CATAN_PORTS_INSTALLED, built}) {
    const std::filesystem::path path = (folder / place / library).lexically_normal();
    if (std::filesystem::exists(path, failed)) return path.string();
  }
  return Error::environment(fmt::format("{} is not there: this Catan was built without {}", library, without), hint);
}

Result<std::string> preload_entry(const Result<std::string>& library) {
  if (!library) return library.error();
  const char* const before = std::getenv(kPreloadVariable);
  const bool other = before != nullptr && *before != '\0';
  return fmt::format("{}={}{}{}", kPreloadVariable, *library, other ? ":" : "", other ? before : "");
}

}  // namespace

Result<std::string> find_ros_library(const char* name) {
  return find_library(name, "../../integrations/ros1", "ROS 1",
                      "install roscpp (scripts/setup.sh --ros1), and build and install Catan again");
}

Result<std::string> ros_preload_entry() { return preload_entry(find_ros_library("libcatan_ros1_preload.so")); }

Result<std::string> threads_preload_entry() {
  return preload_entry(find_library("libcatan_threads.so", "../../integrations/common", "its integrations",
                                    "build and install Catan again, with all of its targets"));
}

}  // namespace ctn::tool
