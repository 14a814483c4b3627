#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>

#include "doctor/checks.h"

namespace ctn::doctor {
namespace {

constexpr Nanos kGoodWakeUp{150'000};  // p99: twice what a small virtual machine needs
constexpr Nanos kPoorWakeUp{1'000'000};
constexpr std::int64_t kUsualTimerSlack = 50'000;  // ns, the kernel's default
constexpr double kSomeSteal = 0.001;
constexpr double kMuchSteal = 0.01;
constexpr double kMuchStealNow = 0.05;  // of a short sample, in which a single tick counts for much

// Three digits are enough, and what is long is long in full.
std::string micros(Nanos duration) {
  const double value = static_cast<double>(duration.count()) / 1000.0;
  return value < 100.0 ? fmt::format("{:.3g} us", value) : fmt::format("{:.0f} us", value);
}

std::string described(const std::vector<WakeUps>& each) {
  const WakeUps all = together(each);
  if (all.lateness.empty()) return "not measured";
  std::string text = fmt::format("median {}, p99 {}", micros(all.percentile(50.0)), micros(all.percentile(99.0)));
  if (each.size() < 2) return text;
  const auto worst = std::max_element(each.begin(), each.end(), [](const WakeUps& one, const WakeUps& other) {
    return one.percentile(99.0) < other.percentile(99.0);
  });
  return text + fmt::format(" (worst: CPU {}, p99 {})", worst->cpu, micros(worst->percentile(99.0)));
}

Nanos worst_p99(const std::vector<WakeUps>& each) {
  Nanos worst{0};
  for (const WakeUps& one : each) worst = std::max(worst, one.percentile(99.0));
  return worst;
}

// The kernel marks what is chosen: "none (voluntary) full".
std::optional<std::string> chosen(const std::optional<std::string>& choices) {
  if (!choices) return std::nullopt;
  const std::size_t begin = choices->find('(');
  const std::size_t end = choices->find(')');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return std::nullopt;
  return choices->substr(begin + 1, end - begin - 1);
}

// The value of a word "KEY=VALUE" of the kernel's command line; the last one counts.
std::optional<std::string> boot_option(const os::LinuxRoots& roots, const std::string& key) {
  std::istringstream words(os::read_line(roots.procfs + "/cmdline").value_or(""));
  std::optional<std::string> value;
  for (std::string word; words >> word;) {
    if (word.starts_with(key + "=")) value = word.substr(key.size() + 1);
  }
  return value;
}

// "full", "lazy", "voluntary", "none", "rt"; nothing where it cannot be told.
std::optional<std::string> preemption(const os::LinuxRoots& roots) {
  const std::string version = os::read_line(roots.procfs + "/version").value_or("");
  if (version.find("PREEMPT_RT") != std::string::npos) return "rt";
  if (os::read_integer(roots.sysfs + "/kernel/realtime").value_or(0) == 1) return "rt";
  if (auto model = chosen(os::read_line(roots.sysfs + "/kernel/debug/sched/preempt"))) return model;
  if (version.find("PREEMPT_DYNAMIC") != std::string::npos) return boot_option(roots, "preempt");
  if (version.find("PREEMPT") != std::string::npos) return "full";
  return std::nullopt;
}

struct Stolen {
  double fraction = 0.0;
  bool known = false;
};

// The first line of /proc/stat: "cpu user nice system idle iowait irq softirq steal guest guest_nice", where the
// guests' time is in user and nice already.
Stolen stolen_since_boot(const os::LinuxRoots& roots) {
  std::istringstream line(os::read_line(roots.procfs + "/stat").value_or(""));
  std::string name;
  line >> name;
  double total = 0.0;
  double value = 0.0;
  for (int field = 0; field < 8; ++field) {
    if (!(line >> value)) return {};
    total += value;
  }
  if (name != "cpu" || total <= 0.0) return {};
  return {value / total, true};
}

}  // namespace

Finding check_clock(const os::LinuxRoots& roots) {
  const std::string folder = roots.sysfs + "/devices/system/clocksource/clocksource0";
  const std::string clock = os::read_line(folder + "/current_clocksource").value_or("");
  if (clock.empty()) return {"clock", Verdict::kOk, "cannot be told", {}, {}, {}};
  constexpr std::array<std::string_view, 5> kSlow = {"hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit"};
  if (std::find(kSlow.begin(), kSlow.end(), clock) == kSlow.end()) {
    return {"clock", Verdict::kOk, clock, {}, {}, {}};
  }
  const std::string available = fmt::format(" {} ", os::read_line(folder + "/available_clocksource").value_or(""));
  const bool has_tsc = available.find(" tsc ") != std::string::npos;
  return {
      "clock",
      Verdict::kWarning,
      clock,
      "reading this clock is a slow access to a device (about 1 us and more, in place of 20 ns), and Catan reads it "
      "several times a run",
      has_tsc ? "use the CPU's own counter"
              : "see why the kernel does not trust the CPU's own counter; if it is known to be good, boot with "
                "tsc=reliable",
      {has_tsc ? fmt::format("echo tsc | sudo tee {}/current_clocksource", folder)
               : "sudo dmesg | grep -i -e tsc -e clocksource"}};
}

Finding check_timer(const Observed& observed) {
  const bool real_time = observed.level != os::Level::kOrdinary;
  const Nanos p99 = worst_p99(observed.wake_ups);
  const std::string found =
      fmt::format("{} threads wake up late by {}", real_time ? "real-time" : "ordinary", described(observed.wake_ups));
  if (p99 <= kGoodWakeUp) return {"timer", Verdict::kOk, found, {}, {}, {}};
  const Verdict verdict = real_time && p99 > kPoorWakeUp ? Verdict::kWarning : Verdict::kNote;
  if (!real_time) {
    return {"timer", verdict, found, "measured at the ordinary level: a busy machine delays it", "see `permission`",
            {}};
  }
  return {
      "timer",
      verdict,
      found,
      "slots begin and triggers come that much late at times",
      "fix first what else is found here (idle, preemption, steal, other real-time programs); highres=off on the "
      "kernel's command line would do this too",
      {"ps -eLo cls,rtprio,psr,pid,comm | grep -E '^ *(FF|RR|DLN)'   # who else is real-time", "cat /proc/cmdline"}};
}

Finding check_timer_slack(const os::LinuxRoots& roots, const Observed& observed) {
  const auto slack = os::read_integer(roots.procfs + "/self/timerslack_ns");
  const std::string found = fmt::format("{}; ordinary threads wake up late by {}",
                                        slack ? micros(Nanos{*slack}) : "unknown", described(observed.ordinary));
  if (!slack || *slack <= kUsualTimerSlack) return {"timer_slack", Verdict::kOk, found, {}, {}, {}};
  return {"timer_slack",
          Verdict::kNote,
          found,
          "the kernel may wake ordinary threads later by that; real-time ones it does not touch",
          "it is inherited: the program that starts the app has set it (prctl PR_SET_TIMERSLACK, or TimerSlackNSec= in "
          "its systemd unit)",
          {fmt::format("sh -c 'echo {} > /proc/$$/timerslack_ns; exec COMMAND'", kUsualTimerSlack)}};
}

Finding check_preemption(const os::LinuxRoots& roots) {
  const auto model = preemption(roots);
  if (!model) return {"preemption", Verdict::kOk, "cannot be told; `timer` shows what comes of it", {}, {}, {}};
  if (*model != "none" && *model != "voluntary") return {"preemption", Verdict::kOk, *model, {}, {}, {}};
  const std::string file = roots.sysfs + "/kernel/debug/sched/preempt";
  return {"preemption",
          Verdict::kNote,
          *model,
          "a thread inside a long system call is not pre-empted before it is done, which delays real-time threads, "
          "seldom by more than a millisecond",
          "let the kernel be pre-empted: now, or from the next boot with preempt=full on its command line",
          {fmt::format("echo full | sudo tee {}", file)}};
}

Finding check_steal(const os::LinuxRoots& roots, const Observed& observed) {
  const Stolen ever = stolen_since_boot(roots);
  if (!ever.known) return {"steal", Verdict::kOk, "cannot be told", {}, {}, {}};
  const double capacity =
      static_cast<double>(observed.measured.count()) * static_cast<double>(observed.topology.online().size());
  const double now = capacity > 0.0 ? static_cast<double>(observed.stolen.count()) / capacity : 0.0;
  const std::string found =
      fmt::format("{:.3g} % of CPU time since boot, {:.3g} % while measuring", 100.0 * ever.fraction, 100.0 * now);
  const bool much = ever.fraction > kMuchSteal || now > kMuchStealNow;
  if (!much && ever.fraction <= kSomeSteal) return {"steal", Verdict::kOk, found, {}, {}, {}};
  return {
      "steal",
      much ? Verdict::kWarning : Verdict::kNote,
      found,
      "the host runs others on this virtual machine's CPUs: runs take longer at times, and nothing in here can "
      "prevent it",
      "on the host, give the virtual CPUs physical ones of their own, or take a machine that is not shared; watch it "
      "(column st)",
      {"vmstat 1 5"}};
}

}  // namespace ctn::doctor
