#include "os/linux/descendants.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string>

namespace ctn::os {
namespace {

// As guardian_process.cpp calls itself.
constexpr std::string_view kGuardianName = "(catan-guard";

// By parent; processes that have ended but were not collected, too.
std::multimap<ProcessId, std::pair<ProcessId, Parentage>> all_by_parent(const LinuxRoots& roots) {
  std::multimap<ProcessId, std::pair<ProcessId, Parentage>> all;
  for (const int number : numbered_entries(roots.procfs, "").value_or(std::vector<int>{})) {
    const std::optional<std::string> stat = read_text(fmt::format("{}/{}/stat", roots.procfs, number));
    if (!stat) continue;
    if (const auto parentage = parse_parentage(*stat)) {
      all.emplace(parentage->parent, std::pair{ProcessId{number}, *parentage});
    }
  }
  return all;
}

}  // namespace

bool adopt_orphans() { return ::prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0; }

void reap_orphans(const std::vector<ProcessId>& own) {
  const auto all = all_by_parent({});
  const auto [begin, end] = all.equal_range(ProcessId{::getpid()});
  for (auto child = begin; child != end; ++child) {
    const auto& [process, parentage] = child->second;
    const bool ours = std::find(own.begin(), own.end(), process) != own.end();
    if (parentage.state == 'Z' && !ours && !parentage.guardian) {
      ::waitpid(static_cast<pid_t>(process), nullptr, WNOHANG);
    }
  }
}

std::vector<ProcessId> descendants(const LinuxRoots& roots) {
  const auto all = all_by_parent(roots);
  std::vector<ProcessId> found{ProcessId{::getpid()}};
  for (std::size_t next = 0; next < found.size(); ++next) {
    const auto [begin, end] = all.equal_range(found[next]);
    for (auto child = begin; child != end; ++child) {
      const auto& [process, parentage] = child->second;
      if (!parentage.guardian && parentage.state != 'Z') found.push_back(process);
    }
  }
  found.erase(found.begin());
  return found;
}

// "PID (NAME) STATE PARENT ...", where the name may hold anything.
std::optional<Parentage> parse_parentage(std::string_view stat) {
  const std::size_t name = stat.find('(');
  const std::size_t name_end = stat.rfind(')');
  if (name == std::string_view::npos || name_end == std::string_view::npos || name_end < name) return std::nullopt;
  const std::string_view rest = stat.substr(name_end + 1);
  if (rest.size() < 4 || rest[0] != ' ' || rest[2] != ' ') return std::nullopt;
  int parent = 0;
  const auto [end, error] = std::from_chars(rest.data() + 3, rest.data() + rest.size(), parent);
  if (error != std::errc{} || end == rest.data() + rest.size() || *end != ' ') return std::nullopt;
  return Parentage{ProcessId{parent}, rest[1], stat.substr(name, name_end - name) == kGuardianName};
}

}  // namespace ctn::os
