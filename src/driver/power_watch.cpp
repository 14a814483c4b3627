#include "driver/power_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ctn::driver {
namespace {

constexpr double kSameRatio = 1e-3;

bool told(const os::PowerState::Cpu& cpu) { return cpu.limit_khz || !cpu.governor.empty(); }

std::string megahertz(const std::optional<long>& khz) {
  return khz ? fmt::format("{} MHz", *khz / 1000) : std::string("no limit told");
}

}  // namespace

struct PowerWatch::Compared {
  os::PowerState::Cpu before;
  os::PowerState::Cpu now;

  bool changed() const { return before != now; }
  std::string describe() const {
    std::string text = fmt::format("CPU {}", now.number);
    if (before.limit_khz != now.limit_khz) {
      text += fmt::format(" {} -> {}", megahertz(before.limit_khz), megahertz(now.limit_khz));
    }
    if (before.governor != now.governor) text += fmt::format(" {} -> {}", before.governor, now.governor);
    return text;
  }
};

std::optional<double> PowerWatch::factor_of(std::size_t kind, const std::vector<Compared>& cpus,
                                            bool mains_changed) const {
  std::optional<double> common;
  bool any_changed = mains_changed;
  bool limits_changed = false;
  for (const Compared& cpu : cpus) {
    if (kinds_.of(cpu.now.number) != kind) continue;
    any_changed = any_changed || cpu.changed();
    limits_changed = limits_changed || cpu.before.limit_khz != cpu.now.limit_khz;
    if (!cpu.before.limit_khz || !cpu.now.limit_khz) {
      if (cpu.before.limit_khz != cpu.now.limit_khz) return std::nullopt;
      continue;
    }
    const double ratio = static_cast<double>(*cpu.before.limit_khz) / static_cast<double>(*cpu.now.limit_khz);
    if (common && std::abs(ratio - *common) > kSameRatio * ratio) return std::nullopt;
    common = ratio;
  }
  if (!any_changed) return 1.0;
  return limits_changed ? common : std::nullopt;
}

std::optional<PowerChange> PowerWatch::update(const os::PowerState& now) {
  std::vector<Compared> compared;
  for (const os::PowerState::Cpu& cpu : now.cpus) {
    if (!told(cpu)) continue;
    const auto before = std::find_if(cpus_.begin(), cpus_.end(),
                                     [&](const os::PowerState::Cpu& other) { return other.number == cpu.number; });
    if (before == cpus_.end()) {
      cpus_.push_back(cpu);
    } else {
      compared.push_back({std::exchange(*before, cpu), cpu});
    }
  }
  const std::optional<bool> mains_before = on_mains_;
  if (now.on_mains) on_mains_ = now.on_mains;
  const bool mains_changed = mains_before && *mains_before != *on_mains_;

  std::string what = mains_changed ? (*on_mains_ ? "on mains" : "on battery") : "";
  for (const Compared& cpu : compared) {
    if (cpu.changed()) what += (what.empty() ? "" : "; ") + cpu.describe();
  }
  if (what.empty()) return std::nullopt;
  PowerChange change{std::move(what), {}};
  for (std::size_t kind = 0; kind < kind_count_; ++kind) {
    change.factors.push_back(factor_of(kind, compared, mains_changed));
  }
  return change;
}

}  // namespace ctn::driver
