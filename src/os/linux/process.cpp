#include "os/linux/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

namespace ctn::os {
namespace {

// Of /proc/TID/stat, as proc(5) counts them. The second, the name, is in parentheses.
constexpr int kFirstFieldAfterName = 3;
constexpr int kFlagsField = 9;
constexpr int kStartTimeField = 22;
constexpr std::uint64_t kExiting = 0x4;  // PF_EXITING

std::optional<std::uint64_t> parse_number(std::string_view stat, int wanted) {
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string_view::npos) return std::nullopt;
  stat.remove_prefix(name_end + 1);
  for (int field = kFirstFieldAfterName; field <= wanted; ++field) {
    if (stat.empty() || stat.front() != ' ') return std::nullopt;
    stat.remove_prefix(1);
    const std::string_view text = stat.substr(0, stat.find_first_of(" \n"));
    stat.remove_prefix(text.size());
    if (text.empty()) return std::nullopt;
    if (field < wanted) continue;
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc() && end == text.data() + text.size()) return number;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> start_time(ThreadId thread, const LinuxRoots& roots) {
  return read_start_time(roots.procfs.c_str(), thread);
}

std::optional<std::uint64_t> parse_start_time(std::string_view stat) { return parse_number(stat, kStartTimeField); }

bool is_ending(ProcessId process, const LinuxRoots& roots) {
  const std::optional<std::string> stat = read_line(fmt::format("{}/{}/stat", roots.procfs, static_cast<int>(process)));
  if (!stat) return true;
  const std::optional<std::uint64_t> flags = parse_number(*stat, kFlagsField);
  return flags && (*flags & kExiting) != 0;
}

std::optional<std::uint64_t> read_start_time(const char* procfs, ThreadId thread) {
  constexpr std::string_view kFile = "/stat";
  constexpr std::size_t kLongestNumber = 11;
  if (static_cast<int>(thread) <= 0) return std::nullopt;
  std::array<char, 1024> buffer{};
  const std::string_view root(procfs);
  if (root.size() + 1 + kLongestNumber + kFile.size() >= buffer.size()) return std::nullopt;
  char* end = std::copy(root.begin(), root.end(), buffer.data());
  *end++ = '/';
  end = std::to_chars(end, end + kLongestNumber, static_cast<int>(thread)).ptr;
  std::copy(kFile.begin(), kFile.end(), end);
  const int file = ::open(buffer.data(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  const ssize_t count = ::read(file, buffer.data(), buffer.size());
  ::close(file);
  if (count <= 0) return std::nullopt;
  return parse_start_time({buffer.data(), static_cast<std::size_t>(count)});
}

std::uint32_t current_user() { return ::geteuid(); }

Descriptor watch_process(ProcessId process) {
  return Descriptor(static_cast<int>(::syscall(SYS_pidfd_open, static_cast<int>(process), 0U)));
}

}  // namespace ctn::os
