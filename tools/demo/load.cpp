#include "load.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

namespace ctn::demo {
namespace {

std::string text_of(const char* path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::optional<CpuTimes> parse_cpu_times(const std::string& stat, const std::string& self_stat) {
  CpuTimes times;
  std::istringstream all(stat);
  std::string word;
  if (!(all >> word) || word != "cpu") return std::nullopt;
  // user nice system idle iowait irq softirq steal; what follows is part of user and nice.
  for (int field = 0; field < 8; ++field) {
    std::int64_t value = 0;
    if (!(all >> value)) return std::nullopt;
    times.total += value;
    if (field != 3 && field != 4) times.busy += value;
  }
  const std::size_t name_end = self_stat.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream self(self_stat.substr(name_end + 1));
  for (int skipped = 0; skipped < 11; ++skipped) self >> word;  // state to cmajflt
  for (int field = 0; field < 4; ++field) {                     // utime stime cutime cstime
    std::int64_t value = 0;
    if (!(self >> value)) return std::nullopt;
    times.ours += value;
  }
  return times;
}

std::optional<CpuTimes> read_cpu_times() { return parse_cpu_times(text_of("/proc/stat"), text_of("/proc/self/stat")); }

double others_share(const std::optional<CpuTimes>& before, const std::optional<CpuTimes>& after) {
  if (!before || !after || after->total <= before->total) return 0.0;
  const auto others = static_cast<double>((after->busy - before->busy) - (after->ours - before->ours));
  return std::clamp(others / static_cast<double>(after->total - before->total), 0.0, 1.0);
}

}  // namespace ctn::demo
