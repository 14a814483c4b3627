#include "policy/cpu_kinds.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

namespace ctn::policy {

CpuKinds::CpuKinds(const graph::App& app, const os::CpuSet& cpus) {
  if (app.core_kinds.empty() || cpus.empty()) return;
  kinds_.resize(static_cast<std::size_t>(cpus.cpus().back()) + 1);
  for (std::size_t core = 0; core < cpus.size(); ++core) {
    kinds_[static_cast<std::size_t>(cpus.cpus()[core])] = app.kind_of(static_cast<int>(core));
  }
}

Status CpuKinds::fits(const graph::App& app, const os::CpuSet& cpus) {
  const std::optional<int> listed = app.core_count();
  if (!listed || static_cast<std::size_t>(*listed) == cpus.size()) return Done{};
  std::string kinds;
  for (const graph::CoreKind& kind : app.core_kinds) {
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", kind.count, kind.name);
  }
  return Error::caller(
      fmt::format("the app lists {} cores ({}), but the session has {} CPUs: {}", *listed, kinds, cpus.size(),
                  os::to_string(cpus)),
      fmt::format("give it {} CPUs, in the order of `cores`; or make the counts there those of the CPUs", *listed));
}

std::size_t CpuKinds::of(int cpu) const {
  const auto index = static_cast<std::size_t>(cpu);
  return cpu >= 0 && index < kinds_.size() ? kinds_[index] : 0;
}

os::CpuSet CpuKinds::of_kind(std::size_t kind, const os::CpuSet& online) const {
  std::vector<int> numbers;
  for (const int cpu : online.cpus()) {
    if (of(cpu) == kind) numbers.push_back(cpu);
  }
  return os::CpuSet(std::move(numbers));
}

graph::App CpuKinds::only_with(const graph::App& app, const os::CpuSet& online) const {
  graph::App other = app;
  for (std::size_t kind = 0; kind < other.core_kinds.size(); ++kind) {
    other.core_kinds[kind].count = static_cast<int>(of_kind(kind, online).size());
  }
  return other;
}

}  // namespace ctn::policy
