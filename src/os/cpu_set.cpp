#include "os/cpu_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace ctn::os {
namespace {

// Far above any machine that runs Linux (8192 CPUs), and low enough that a typing mistake fills no memory.
constexpr int kMaxCpuNumber = 65535;

std::optional<int> parse_cpu_number(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (number < 0 || number > kMaxCpuNumber || text.front() == '-') return std::nullopt;
  return number;
}

// "5" or "0-3".
std::optional<std::pair<int, int>> parse_cpu_range(std::string_view text) {
  const std::size_t dash = text.find('-');
  const std::optional<int> first = parse_cpu_number(text.substr(0, dash));
  const std::optional<int> last = dash == std::string_view::npos ? first : parse_cpu_number(text.substr(dash + 1));
  if (!first || !last || *first > *last) return std::nullopt;
  return std::pair{*first, *last};
}

}  // namespace

CpuSet::CpuSet(std::vector<int> cpus) : cpus_(std::move(cpus)) {
  std::sort(cpus_.begin(), cpus_.end());
  cpus_.erase(std::unique(cpus_.begin(), cpus_.end()), cpus_.end());
}

bool CpuSet::contains(int cpu) const { return std::binary_search(cpus_.begin(), cpus_.end(), cpu); }

CpuSet common(const CpuSet& some, const CpuSet& others) {
  std::vector<int> both;
  for (const int cpu : some.cpus()) {
    if (others.contains(cpu)) both.push_back(cpu);
  }
  return CpuSet(std::move(both));
}

Result<CpuSet> parse_cpu_list(const std::string& text) {
  std::vector<int> cpus;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    const auto range = parse_cpu_range(part);
    const bool dangling_comma = comma != std::string_view::npos && comma + 1 == rest.size();
    if (!range || dangling_comma) {
      return Error::caller(
          fmt::format("'{}' is no list of CPUs{}", trimmed(text),
                      range ? ": it ends in a comma" : fmt::format(": '{}' is no CPU or range", part)),
          fmt::format("write CPU numbers (0 to {}) and ranges with commas between, as in 0-3,5", kMaxCpuNumber));
    }
    // Overlapping ranges could otherwise pile up without bound before the set removes what is double.
    if (cpus.size() > 2 * static_cast<std::size_t>(kMaxCpuNumber)) cpus = CpuSet(std::move(cpus)).cpus();
    for (int cpu = range->first; cpu <= range->second; ++cpu) cpus.push_back(cpu);
    rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
  }
  return CpuSet(std::move(cpus));
}

std::string to_string(const CpuSet& cpus) {
  std::string text;
  const std::vector<int>& numbers = cpus.cpus();
  for (std::size_t first = 0; first < numbers.size();) {
    std::size_t last = first;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += first == last ? fmt::format("{}", numbers[first]) : fmt::format("{}-{}", numbers[first], numbers[last]);
    first = last + 1;
  }
  return text;
}

}  // namespace ctn::os
