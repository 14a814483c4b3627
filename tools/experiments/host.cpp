#include "experiments/host.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "os/linux/linux_os.h"

namespace ctn::experiments {
namespace {

// The last CPU that may be used, for the first ones serve most interrupts; and with it the last of another core.
std::vector<std::vector<int>> choose_cpus(const os::Topology& topology, const os::CpuSet& allowed) {
  std::vector<os::Cpu> usable;
  for (const os::Cpu& cpu : topology.cpus) {
    if (cpu.online && allowed.contains(cpu.number)) usable.push_back(cpu);
  }
  if (usable.empty()) return {};
  const os::Cpu& one = usable.back();
  std::vector<std::vector<int>> sets = {{one.number}};
  const auto other = std::find_if(usable.rbegin(), usable.rend(), [&](const os::Cpu& cpu) {
    return cpu.core != one.core || cpu.package != one.package;
  });
  if (other != usable.rend()) {
    sets.push_back({other->number, one.number});
  } else if (usable.size() > 1) {
    sets.push_back({usable[usable.size() - 2].number, one.number});
  }
  return sets;
}

// The operating system layer advises for the program that asks, which is this one.
std::string advice_for(const std::string& program, std::string text) {
  std::error_code error;
  const std::string self = std::filesystem::read_symlink("/proc/self/exe", error).string();
  const std::size_t at = self.empty() ? std::string::npos : text.find(self);
  return at == std::string::npos ? text : text.replace(at, self.size(), program);
}

}  // namespace

report::Table table_of(const Facts& facts) {
  report::Table table{.header = {"Fact", "Value"}};
  for (const auto& [name, value] : facts) table.rows.push_back({name, value});
  return table;
}

Result<Host> look_at_host(const std::string& program) {
  const auto system = os::make_linux_os();
  const auto topology = system->topology();
  if (!topology) return topology.error();
  const auto allowed = system->affinity(system->current_thread());
  if (!allowed) return allowed.error();

  Host host;
  host.cpu_sets = choose_cpus(*topology, *allowed);
  if (host.cpu_sets.empty()) return Error::environment("no CPU may be used", "look at taskset -p $$");
  const os::RealTimeFacts real_time = system->real_time_facts();
  if (!real_time.permitted) host.no_real_time = advice_for(program, real_time.why_not);
  const os::HostFacts facts = system->host_facts();
  const auto add = [&](const std::string& name, const std::string& value) {
    host.facts.emplace_back(name, value.empty() ? "unknown" : value);
  };
  add("Processor", facts.cpu_model);
  add("CPUs", std::to_string(facts.cpu_count));
  add("CPUs of the trials", os::to_string(os::CpuSet(host.cpu_sets.back())));
  add("Linux", facts.kernel);
  add("Frequency governor", facts.governor);
  add("Kept for ordinary threads", fmt::format("{:.1f} % ({})", 100.0 * real_time.reserved, real_time.reserved_by));
  add("Real-time levels", real_time.permitted ? "granted" : "refused");
  add("Measured at (UTC)", facts.utc);
  return host;
}

}  // namespace ctn::experiments
