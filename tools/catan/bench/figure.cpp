#include "bench/figure.h"

#include <fmt/format.h>

#include <utility>

#include "table.h"

namespace ctn::tool {
namespace {

std::string number(double value) { return fmt::format("{:.{}f}", value, value < 10.0 ? 2 : 1); }

std::string verdict(const Figure& figure) {
  if (!figure.met()) return {};
  return *figure.met() ? "met" : "missed";
}

}  // namespace

std::optional<double> Figure::ratio() const {
  if (baseline.count == 0 || measured.count == 0 || baseline.p50 <= 0.0) return std::nullopt;
  return measured.p50 / baseline.p50;
}

std::optional<bool> Figure::met() const {
  if (measured.count == 0 || (!goal.ratio && !goal.p50 && !goal.p99)) return std::nullopt;
  if (goal.ratio && (!ratio() || *ratio() > *goal.ratio)) return false;
  if (goal.p50 && measured.p50 > *goal.p50) return false;
  return !goal.p99 || measured.p99 <= *goal.p99;
}

Summary summarize_micros(const std::vector<Nanos>& samples) {
  std::vector<double> micros;
  micros.reserve(samples.size());
  for (const Nanos sample : samples) micros.push_back(static_cast<double>(sample.count()) / 1000.0);
  return summarize(std::move(micros));
}

std::string goal_text(const Goal& goal) {
  std::vector<std::string> limits;
  if (goal.ratio) limits.push_back(fmt::format("<= {}x", *goal.ratio));
  if (goal.p50) limits.push_back(fmt::format("p50 <= {}", *goal.p50));
  if (goal.p99) limits.push_back(fmt::format("p99 <= {}", *goal.p99));
  return fmt::format("{}", fmt::join(limits, ", "));
}

std::string figures_text(const std::vector<Figure>& figures) {
  Table table({"figure", "where", "unit", "p50", "p99", "bare p50", "bare p99", "ratio", "goal", "verdict"});
  for (const Figure& figure : figures) {
    const bool bare = figure.baseline.count > 0;
    const std::optional<double> ratio = figure.ratio();
    table.add({figure.name, figure.where, figure.unit, number(figure.measured.p50), number(figure.measured.p99),
               bare ? number(figure.baseline.p50) : "", bare ? number(figure.baseline.p99) : "",
               ratio ? fmt::format("{:.2f}", *ratio) : "", goal_text(figure.goal), verdict(figure)});
  }
  std::string text = table.text();
  std::string bare;
  for (const Figure& figure : figures) {
    if (figure.baseline_is.empty() || bare.find(figure.baseline_is) != std::string::npos) continue;
    bare += fmt::format("  {}: {}\n", figure.name, figure.baseline_is);
  }
  if (!bare.empty()) text += "\nBare, measured in turn with it:\n" + bare;
  return text;
}

}  // namespace ctn::tool
