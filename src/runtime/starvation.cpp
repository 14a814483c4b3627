#include "runtime/starvation.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "dispatch/standstill.h"

namespace ctn::runtime {
namespace {

constexpr Nanos kReportPeriod = std::chrono::seconds{10};

}  // namespace

void Starvation::woke_late(int cpu, TimePoint due, TimePoint woke) {
  TimePoint& counted_until = counted_until_[cpu];
  const TimePoint begin = std::max(due, counted_until);
  counted_until = std::max(counted_until, woke);
  if (dispatch::stood_still(begin, woke)) {
    stopped_ = begin;
    resumed_ = woke;
  } else if (woke - begin >= kStarvedAfter) {
    late_.push_back({cpu, begin, woke});
  }
}

void Starvation::stolen_until_now(std::map<int, Nanos> stolen) {
  std::map<int, Nanos> taken;
  for (const auto& [cpu, since_boot] : stolen) {
    const auto before = stolen_.find(cpu);
    if (before != stolen_.end()) taken[cpu] = since_boot - before->second;
  }
  stolen_ = std::move(stolen);
  for (const Late& late : std::exchange(late_, {})) {
    const bool stopped = stopped_ <= late.due && late.due < resumed_;
    const Nanos slept = std::max(late.woke - (stopped ? resumed_ : late.due), Nanos{0});
    const Nanos excused = std::min(slept, std::max(taken[late.cpu], Nanos{0}));
    taken[late.cpu] -= excused;
    const Nanos starved = slept - excused;
    if (starved < kStarvedAfter) continue;
    ++times_;
    total_ += starved;
    longest_ = std::max(longest_, starved);
    last_cpu_ = late.cpu;
  }
}

std::optional<std::string> Starvation::message(TimePoint now) {
  if (times_ == reported_ || (reported_ > 0 && now < reported_at_ + kReportPeriod)) return std::nullopt;
  reported_ = times_;
  reported_at_ = now;
  return fmt::format(
      "CPU {} was kept from real-time threads for longer than {} ms; so far {} times on all CPUs, {:.0f} ms in all, "
      "{:.0f} ms at the most. The kernel gave it to ordinary threads, which more slack prevents, or a host to others",
      last_cpu_, std::chrono::duration_cast<std::chrono::milliseconds>(kStarvedAfter).count(), times_,
      to_millis(total_).count(), to_millis(longest_).count());
}

}  // namespace ctn::runtime
