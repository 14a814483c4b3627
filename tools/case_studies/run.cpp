#include "run.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <ranges>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/snapshot_json.h"
#include "program/text_file.h"

namespace ctn::case_studies {
namespace {

using Json = nlohmann::ordered_json;

bool is_over_time(const std::string& name, const Json& value) {
  return name.find("_by_") != std::string::npos && value.is_array() &&
         std::ranges::all_of(value, [](const Json& item) { return item.is_number() || item.is_null(); });
}

RunOptions options_in(const Json& common) {
  RunOptions options;
  for (const auto& [name, value] : common.items()) {
    if (!value.is_object()) options[name] = value.dump();
    if (!value.is_object()) continue;
    for (const auto& [part, of_part] : value.items()) options[fmt::format("{}.{}", name, part)] = of_part.dump();
  }
  return options;
}

constexpr std::optional<double> kInfinite = std::numeric_limits<double>::infinity();

// `complete(list)`: what a run's list counts as.
template <class Complete>
ByTime medians_of_lists(const std::vector<StoredRun>& runs, const std::string& name, const Complete& complete) {
  std::vector<ByTime> lists;
  for (const StoredRun& run : runs) {
    const auto list = run.by_time.find(name);
    if (list == run.by_time.end()) continue;
    complete(lists.emplace_back(list->second));
  }
  return program::medians_by_time(lists, (runs.size() + 1) / 2);
}

}  // namespace

std::optional<double> StoredRun::figure(const std::string& name) const {
  const auto found = figures.find(name);
  return found == figures.end() ? std::nullopt : std::optional(found->second);
}

std::optional<RunOptions> parse_options(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? std::optional(options_in(json)) : std::nullopt;
}

Result<StoredRun> parse_run(const std::string& text, const std::string& file) {
  const Json json = Json::parse(text, nullptr, false);
  if (!program::has_figures(json) || !json.contains("seed") || !json["seed"].is_number_unsigned()) {
    return Error::environment(file + " is no outcome of a run", "delete it, and run again");
  }
  StoredRun run;
  run.seed = json["seed"];
  for (const program::Figure& figure : program::figures_in(json)) {
    if (figure.value) run.figures[figure.name] = *figure.value;
  }
  for (const auto& [name, value] : json.items()) {
    if (is_over_time(name, value)) run.by_time[name] = program::by_time_in(value);
  }
  const auto common = program::common_options_in(json);
  if (!common) return Error::environment(file + " does not name what is in common", "delete it, and run again");
  run.options = options_in(*common);
  return run;
}

Result<std::vector<StoredRun>> read_runs(const std::filesystem::path& folder, std::uint64_t first, int count) {
  std::vector<StoredRun> runs;
  for (int number = 0; number < count; ++number) {
    const std::filesystem::path path = folder / program::file_of_run(first + static_cast<std::uint64_t>(number));
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    Result<StoredRun> run = parse_run(program::text_of_file(path.string()).value_or(""), path.string());
    if (!run) return run.error();
    runs.push_back(std::move(run).value());
  }
  return runs;
}

ByTime medians_by_time(const std::vector<StoredRun>& runs, const std::string& name) {
  return medians_of_lists(runs, name, [](ByTime&) {});
}

ByTime medians_with_never(const std::vector<StoredRun>& runs, const std::string& name) {
  return medians_of_lists(runs, name,
                          [](ByTime& list) { std::ranges::replace(list, std::optional<double>(), kInfinite); });
}

ByTime medians_of_periods(const std::vector<StoredRun>& runs, const std::string& name) {
  return medians_of_lists(runs, name, [](ByTime& list) {
    const auto last =
        std::ranges::find_if(list.rbegin(), list.rend(), [](const auto& value) { return value.has_value(); });
    std::optional<double> next = last == list.rend() ? kInfinite : *last;
    for (auto value = list.rbegin(); value != list.rend(); ++value) {
      if (!*value) *value = next;
      next = *value;
    }
  });
}

std::optional<double> mean_between(const StoredRun& run, const std::string& name, double from, double to) {
  const auto list = run.by_time.find(name);
  if (list == run.by_time.end()) return std::nullopt;
  const auto length = static_cast<double>(list->second.size());
  std::vector<double> values;
  for (std::size_t stretch = 0; stretch < list->second.size(); ++stretch) {
    const double middle = (static_cast<double>(stretch) + 0.5) / length;
    if (middle >= from && middle < to && list->second[stretch]) values.push_back(*list->second[stretch]);
  }
  return program::mean_of(values);
}

}  // namespace ctn::case_studies
