#include "flight/find.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/text.h"
#include "flight/layout.h"

namespace ctn::flight {
namespace {

// A process that has several flight recorders is listed once for each.
struct Candidate {
  std::int32_t process = 0;
  std::string app;  // its name
  os::Descriptor memory;
};

std::optional<std::int32_t> number_of(std::string_view text) {
  std::int32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 1) return std::nullopt;
  return number;
}

// The app of the memory that a link in /proc/PID/fd leads to.
std::optional<std::string> app_of(const std::filesystem::path& link) {
  std::error_code unreadable;
  const std::string target = std::filesystem::read_symlink(link, unreadable).string();
  const std::string before = std::string("/memfd:") + kMemoryName;
  constexpr std::string_view kAfter = " (deleted)";
  if (unreadable || !target.starts_with(before) || !target.ends_with(kAfter)) return std::nullopt;
  return target.substr(before.size(), target.size() - before.size() - kAfter.size());
}

// Only the writer's descriptor counts: readers have descriptors of the memory, too.
bool is_written_by(const os::Descriptor& memory, std::int32_t process) {
  alignas(Head) std::array<std::byte, sizeof(Head)> bytes{};
  if (::pread(memory.number(), bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return false;
  const auto* const head = reinterpret_cast<const Head*>(bytes.data());
  return head->magic.load() == kMagic && head->process.load() == static_cast<Word>(process) && head->over.load() == 0;
}

// Those of one process: each memory once, however many descriptors of it the process has.
void add_recorders_of(std::int32_t process, const std::filesystem::path& descriptors, std::vector<Candidate>& to) {
  std::vector<std::filesystem::path> known;
  std::error_code unreadable;
  for (std::filesystem::directory_iterator entry(descriptors, unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    std::optional<std::string> app = app_of(entry->path());
    if (!app) continue;
    os::Descriptor memory(::open(entry->path().c_str(), O_RDONLY | O_CLOEXEC));
    if (!memory.valid() || !is_written_by(memory, process)) continue;
    const bool again = std::any_of(known.begin(), known.end(), [&](const std::filesystem::path& other) {
      std::error_code gone;
      return std::filesystem::equivalent(entry->path(), other, gone);
    });
    if (again) continue;
    known.push_back(entry->path());
    to.push_back({process, std::move(*app), std::move(memory)});
  }
}

std::vector<Candidate> candidates() {
  std::vector<Candidate> all;
  std::error_code unreadable;
  for (std::filesystem::directory_iterator entry("/proc", unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    const std::optional<std::int32_t> process = number_of(entry->path().filename().string());
    if (process) add_recorders_of(*process, entry->path() / "fd", all);
  }
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.process < b.process; });
  return all;
}

std::string list_of(const std::vector<Candidate>& all) {
  std::string text;
  for (const Candidate& candidate : all) {
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", candidate.process, printable(candidate.app));
  }
  return text;
}

}  // namespace

Result<os::Descriptor> find(const std::string& app_or_process) {
  std::vector<Candidate> all = candidates();
  if (!app_or_process.empty()) {
    const std::optional<std::int32_t> process = number_of(app_or_process);
    std::erase_if(all, [&](const Candidate& candidate) {
      return candidate.app != app_or_process && candidate.process != process;
    });
  }
  if (all.size() == 1) return std::move(all.front().memory);
  if (all.empty()) {
    return Error::caller(app_or_process.empty()
                             ? "no app is scheduled by Catan here, or by a user whose processes you may not look at"
                             : fmt::format("no process schedules an app called {}", quote(app_or_process)),
                         "start it, name its app or its process, or look as the user that it runs as, or as root");
  }
  return Error::caller("several apps are scheduled here: processes " + list_of(all), "name one process");
}

}  // namespace ctn::flight
