#include "status_line.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <cstdio>
#include <string_view>
#include <vector>

#include "command.h"

namespace ctn::tool {
namespace {

// The first, and how many more there are: it is one line.
std::string first_of(std::string_view first, std::size_t count) {
  return count > 1 ? fmt::format("{} and {} more", first, count - 1) : std::string(first);
}

std::string plan_text(const Snapshot& snapshot) {
  std::string text;
  if (!snapshot.relaxed.empty()) {
    text += fmt::format("  bounds relaxed by {:.3g} ({})", snapshot.relax_factor,
                        first_of(snapshot.relaxed.front().bound, snapshot.relaxed.size()));
  }
  if (!snapshot.assumed.empty()) {
    text += fmt::format("  cost assumed of {}", first_of(snapshot.assumed.front().node, snapshot.assumed.size()));
  }
  return text;
}

// Opened anew: stderr itself is shared with whoever else writes on it, and expects that a write waits.
os::Descriptor open_screen() {
  std::array<char, PATH_MAX> name{};
  if (ttyname_r(STDERR_FILENO, name.data(), name.size()) != 0) return {};
  return os::Descriptor(open(name.data(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
}

}  // namespace

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) == 1) {
  if (terminal_) screen_ = open_screen();
}

void StatusLine::show(const std::string& line) const {
  const std::string text = "\r\033[K" + line;
  if (screen_.valid()) {
    static_cast<void>(write(screen_.number(), text.data(), text.size()) >= 0);
  } else if (terminal_) {
    print_on_stderr(text);
  }
}

bool ProgressLine::is_due() {
  constexpr std::chrono::milliseconds kBetween{200};
  const auto now = std::chrono::steady_clock::now();
  if (!line_.shown() || now < next_) return false;
  next_ = now + kBetween;
  return true;
}

void ProgressLine::show(double part) {
  if (is_due()) line_.show(fmt::format("{}: {:.0f} %", what_, 100.0 * part));
}

void ProgressLine::end() {
  next_ = std::chrono::steady_clock::time_point::max();
  line_.show({});
}

void ProgressLine::show_count(std::uint64_t count) {
  if (is_due()) line_.show(fmt::format("{}: {} events", what_, count));
}

std::string status_text(const Snapshot& snapshot, double measured_s, std::optional<double> seconds) {
  if (!snapshot.warmed_up) return "warming up";
  std::string line = fmt::format("{:.1f} s", measured_s);
  if (seconds) line = fmt::format("{:.1f} of {:.6g} s", measured_s, *seconds);
  if (snapshot.chains.empty()) return line + plan_text(snapshot);
  const ChainSnapshot& chain = snapshot.chains.front();
  line += fmt::format("  {:.1f} Hz  response {:.4g} ms", snapshot.source_hz, chain.response_ms.mean);
  if (chain.predicted_response_ms) line += fmt::format(" (predicted {:.4g})", *chain.predicted_response_ms);
  return line + plan_text(snapshot);
}

}  // namespace ctn::tool
