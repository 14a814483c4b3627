#include "os/linux/control_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

namespace ctn::os {
namespace {

struct Line {
  std::string controllers;
  std::string path;
};

// Lines of /proc/self/cgroup: "number:controllers:path"; version 2 names no controllers.
std::optional<Line> parse(std::string_view line) {
  const std::size_t first = line.find(':');
  const std::size_t second = first == std::string_view::npos ? first : line.find(':', first + 1);
  if (second == std::string_view::npos || second + 1 >= line.size() || line[second + 1] != '/') return std::nullopt;
  return Line{std::string(line.substr(first + 1, second - first - 1)), std::string(line.substr(second + 1))};
}

bool names(const std::string& controllers, std::string_view controller) {
  return fmt::format(",{},", controllers).find(fmt::format(",{},", controller)) != std::string::npos;
}

std::optional<Line> find_line(const LinuxRoots& roots, std::string_view controller) {
  const std::string text = read_text(roots.procfs + "/self/cgroup").value_or("");
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const auto line = parse(std::string_view(text).substr(begin, end - begin));
    if (line && (controller.empty() ? line->controllers.empty() : names(line->controllers, controller))) return line;
    begin = end + 1;
  }
  return std::nullopt;
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

std::vector<std::string> mounts(const LinuxRoots& roots, const std::string& controllers, std::string_view controller) {
  const std::string top = roots.sysfs + "/fs/cgroup";
  if (controller.empty()) return {top + "/unified", top};
  return {fmt::format("{}/{}", top, controllers), fmt::format("{}/{}", top, controller)};
}

}  // namespace

std::vector<std::string> cgroup_folders(const LinuxRoots& roots, std::string_view controller) {
  const auto line = find_line(roots, controller);
  if (!line) return {};
  for (const std::string& mount : mounts(roots, line->controllers, controller)) {
    if (!is_folder(mount)) continue;
    std::vector<std::string> folders{mount};
    if (line->path == "/" || !is_folder(mount + line->path)) return folders;
    for (std::size_t slash = 0; slash != std::string::npos;) {
      slash = line->path.find('/', slash + 1);
      folders.push_back(mount + line->path.substr(0, slash));
    }
    return folders;
  }
  return {};
}

}  // namespace ctn::os
