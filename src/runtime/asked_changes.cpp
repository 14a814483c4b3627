#include "runtime/asked_changes.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "graph/change.h"

namespace ctn::runtime {

Status AskedChanges::ask(const Changes& changes) {
  const std::lock_guard lock(mutex_);
  Result<os::CpuSet> cpus = choose(changes);
  Result<graph::App> app = graph::changed(state_.app, changes);
  std::vector<Problem> problems;
  if (!cpus) problems = cpus.error().problems();
  if (!app) problems.insert(problems.end(), app.error().problems().begin(), app.error().problems().end());
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  state_ = {std::move(*app), std::move(*cpus)};
  ++count_;
  taken_ = false;
  return Done{};
}

Result<os::CpuSet> AskedChanges::choose(const Changes& changes) const {
  if (!changes.cpus) return state_.cpus;
  const os::CpuSet asked(*changes.cpus);
  const std::string hint =
      fmt::format("choose from {}: what it was not given at the start it cannot use later", os::to_string(given_));
  std::vector<Problem> problems;
  if (asked.empty()) problems.push_back({{}, "cpus", "no CPU is left to plan for", hint});
  for (const int cpu : asked.cpus()) {
    if (!given_.contains(cpu)) {
      problems.push_back({{}, "cpus", fmt::format("CPU {} is not one of those that were given", cpu), hint});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return asked;
}

std::optional<AskedChanges::State> AskedChanges::take() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(taken_, true)) return std::nullopt;
  return state_;
}

AskedChanges::State AskedChanges::now() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

std::uint64_t AskedChanges::count() const {
  const std::lock_guard lock(mutex_);
  return count_;
}

}  // namespace ctn::runtime
