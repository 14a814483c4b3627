// Reading the small text files under /proc and /sys. Whatever is missing, empty or odd comes back as "nothing", never
// as a wrong value: what the kernel shows differs from machine to machine.
//
// Thread safety: pure functions of the file system.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ctn::os {

// Where the kernel's files are; tests point them to a fabricated tree.
struct LinuxRoots {
  std::string sysfs = "/sys";
  std::string procfs = "/proc";
  std::string devices = "/dev";
};

// The whole file, at most one MiB of it; nothing when it cannot be read.
std::optional<std::string> read_text(const std::string& path);
// The first line without blanks around it; nothing when it cannot be read or is empty.
std::optional<std::string> read_line(const std::string& path);
// The first line as one decimal number; nothing when it is anything else.
std::optional<std::int64_t> read_integer(const std::string& path);
std::optional<std::int64_t> parse_integer(std::string_view text);

// The value of the first line "KEY : value" in a text such as /proc/cpuinfo; nothing when there is none.
std::optional<std::string> find_value(std::string_view text, std::string_view key);

// N of the folder's entries that are called PREFIXN, ascending; nothing when the folder cannot be read.
std::optional<std::vector<int>> numbered_entries(const std::string& folder, std::string_view prefix);

}  // namespace ctn::os
