#include "why_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/text.h"
#include "report/table.h"

namespace ctn::tool {
namespace {

constexpr std::int64_t kBarWidth = 40;

std::string in_ms(Nanos duration) { return fmt::format("{:.3f}", to_millis(duration).count()); }

std::string name_of(const graph::App& app, std::optional<NodeId> node) {
  return node ? printable(app.graph.node(*node).name) : "";
}

// Shows where in the response a part lies.
std::string bar(const why::Response& response, const why::Part& part) {
  const auto column = [&](TimePoint time) {
    return static_cast<std::size_t>((time - response.begin) * kBarWidth / response.length());
  };
  const std::size_t from = std::min<std::size_t>(column(part.begin), kBarWidth - 1);
  const std::size_t to = std::max(column(part.end), from + 1);
  return std::string(from, '.') + std::string(to - from, '#') + std::string(kBarWidth - to, '.');
}

report::Table timeline(const why::Response& response, const graph::App& app) {
  report::Table table{.header = {"after ms", "ms", "part", "node", "by", ""}};
  for (const why::Part& part : response.parts) {
    table.rows.push_back({in_ms(part.begin - response.begin), in_ms(part.length()), why::to_string(part.kind),
                          name_of(app, part.node), name_of(app, part.by), bar(response, part)});
  }
  return table;
}

std::string cause_counts(const why::Analysis& analysis) {
  report::Table table{.header = {"cause", "late responses"}};
  for (const auto& [cause, count] : why::causes_by_count(analysis)) {
    table.rows.push_back({why::to_string(cause), std::to_string(count)});
  }
  return table.rows.empty() ? "" : "\nCauses of the late ones (docs/why.md)\n" + to_text(table);
}

std::string usual_parts(const why::Analysis& analysis, const graph::App& app) {
  report::Table table{.header = {"part", "node", "median ms"}};
  for (const why::UsualPart& part : analysis.usual) {
    table.rows.push_back({why::to_string(part.kind), name_of(app, part.node), in_ms(part.median)});
  }
  return table.rows.empty() ? "" : "\nWhat is usual: each part's median over all responses\n" + to_text(table);
}

}  // namespace

std::string why_text(const why::Analysis& analysis, const graph::App& app, TimePoint started) {
  const std::string chain = printable(app.graph.path_name(app.objective[analysis.term].path));
  if (analysis.responses == 0) return chain + ": no response was measured; --all includes the warm-up\n";
  std::string text =
      fmt::format("{}: {} responses, {} late: over {} ms, {}\nAt most 2 % is unexplained in {:.2f} % of them.\n", chain,
                  analysis.responses, analysis.late, in_ms(analysis.late_over),
                  analysis.bound ? "the chain's bound" : "the 99th percentile of its responses, since it has no bound",
                  100.0 * static_cast<double>(analysis.explained) / static_cast<double>(analysis.responses));
  text += cause_counts(analysis) + usual_parts(analysis, app);
  for (const why::Response& response : analysis.worst) {
    text += fmt::format("\n{} ms, {:.3f} s after the start: {}\n{}", in_ms(response.length()),
                        to_millis(response.begin - started).count() / 1000.0,
                        response.cause ? printable(why::in_words(*response.cause, app.graph)) : "not late",
                        to_text(timeline(response, app)));
  }
  return text;
}

}  // namespace ctn::tool
