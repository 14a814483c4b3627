#include "ros_libraries.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

namespace ctn::tool {
namespace {

constexpr const char* kPreloadLibrary = "libcatan_ros1_preload.so";
constexpr const char* kPreloadVariable = "LD_PRELOAD";

}  // namespace

// Beside the command: where both are built, or installed.
Result<std::string> find_ros_library(const char* name) {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path();
  for (const char* const place : {CATAN_ROS1_INSTALLED, "../../integrations/ros1"}) {
    const std::filesystem::path path = (folder / place / name).lexically_normal();
    if (std::filesystem::exists(path, failed)) return path.string();
  }
  return Error::environment(fmt::format("{} is not there: this Catan was built without ROS 1", name),
                            "install roscpp (scripts/setup.sh --ros1), and build and install Catan again");
}

Result<std::string> ros_preload_entry() {
  const auto library = find_ros_library(kPreloadLibrary);
  if (!library) return library.error();
  const char* const before = std::getenv(kPreloadVariable);
  const bool other = before != nullptr && *before != '\0';
  return fmt::format("{}={}{}{}", kPreloadVariable, *library, other ? ":" : "", other ? before : "");
}

}  // namespace ctn::tool
