#include "record/app_changes.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <utility>

#include "graph/change.h"

namespace ctn::record {
namespace {

using What = AppChange::What;

constexpr std::array<std::pair<What, const char*>, 3> kWords{
    {{What::kWeight, "weight"}, {What::kMax, "max"}, {What::kMinRate, "min_rate"}}};

std::optional<double> in_ms(const std::optional<Nanos>& duration) {
  return duration ? std::optional(to_millis(*duration).count()) : std::nullopt;
}
std::optional<double> in_hz(const std::optional<Rate>& rate) {
  return rate ? std::optional(rate->hertz()) : std::nullopt;
}

Changes as_asked(const graph::App& app, const AppChange& change) {
  Changes changes;
  const std::string item = std::to_string(change.item);
  switch (change.what) {
    case What::kWeight:
      changes.weights.push_back({item, change.after.value_or(0.0)});
      break;
    case What::kMax:
      changes.maxes.push_back({item, change.after});
      break;
    case What::kMinRate:
      changes.min_rates.push_back({app.graph.node(NodeId(change.item)).name, change.after});
      break;
  }
  return changes;
}

std::string text_of(What what, const std::optional<double>& value) {
  if (!value) return "none";
  const char* const unit = what == What::kMax ? "ms" : what == What::kMinRate ? "Hz" : "";
  return fmt::format("{:.6g}{}", *value, unit);
}

}  // namespace

const char* to_string(What what) {
  for (const auto& [known, word] : kWords) {
    if (known == what) return word;
  }
  return "";
}

std::optional<What> change_named(std::string_view what) {
  for (const auto& [known, word] : kWords) {
    if (what == word) return known;
  }
  return std::nullopt;
}

std::vector<AppChange> differences(const graph::App& before, const graph::App& after, TimePoint at) {
  std::vector<AppChange> changes;
  const auto compare = [&](What what, std::size_t item, std::optional<double> old, std::optional<double> now) {
    if (old != now) changes.push_back({at, what, item, old, now});
  };
  for (std::size_t term = 0; term < before.objective.size(); ++term) {
    compare(What::kWeight, term, before.objective[term].weight, after.objective[term].weight);
    compare(What::kMax, term, in_ms(before.objective[term].max), in_ms(after.objective[term].max));
  }
  for (std::size_t node = 0; node < before.graph.nodes().size(); ++node) {
    compare(What::kMinRate, node, in_hz(before.graph.nodes()[node].min_rate),
            in_hz(after.graph.nodes()[node].min_rate));
  }
  return changes;
}

Result<graph::App> app_after(const graph::App& app, std::span<const AppChange> changes) {
  Result<graph::App> changed = app;
  for (const AppChange& change : changes) {
    changed = graph::changed(*changed, as_asked(app, change));
    if (!changed) return changed;
  }
  return changed;
}

std::string describe(const graph::App& app, const AppChange& change) {
  const std::string key = change.what == What::kMinRate
                              ? fmt::format("nodes.{}.min_rate", app.graph.node(NodeId(change.item)).name)
                              : fmt::format("objective[{}].{} ({})", change.item, to_string(change.what),
                                            graph::term_name(app, app.objective[change.item]));
  return fmt::format("{}: {} -> {}", key, text_of(change.what, change.before), text_of(change.what, change.after));
}

}  // namespace ctn::record
