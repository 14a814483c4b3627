#include "page/late.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "report/escape.h"
#include "report/text.h"

namespace ctn::page {
namespace {

using report::escaped;

// These limits keep pages of apps with many chains small.
constexpr std::size_t kMaxStretches = 20'000;  // of all chains together
constexpr std::size_t kMaxParts = 12;          // of the parts of a response
constexpr std::size_t kManyChains = 50;        // more than this: each shows its longest response alone

using Sums = std::vector<std::pair<std::pair<why::PartKind, NodeId>, Nanos>>;

// The longest first.
Sums sums_of(const why::Response& response) {
  std::map<std::pair<why::PartKind, NodeId>, Nanos> by_whose;
  for (const why::Part& part : response.parts) by_whose[why::whose(part)] += part.length();
  Sums sums(by_whose.begin(), by_whose.end());
  std::stable_sort(sums.begin(), sums.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  return sums;
}

std::string ms_text(Nanos duration) { return fmt::format("{:.3f}", to_millis(duration).count()); }

class Late {
 public:
  Late(report::Page& page, const Story& story, const why::Analysis& late)
      : page_(page), story_(story), late_(late), started_(story.figures.header.started) {
    const std::size_t chains = story.responses.size();
    shown_ = std::min(late.worst.size(), chains > kManyChains ? 1 : kWorstShown);
    columns_ = std::clamp<std::size_t>(kMaxStretches / std::max<std::size_t>(chains * kWorstShown, 1), 20, 400);
  }

  void write() {
    page_.element("<div class=\"late\">");
    const std::string by_cause = late_.late > 0 ? " By cause: " + report::causes_in_words(late_) + "." : "";
    page_.element(fmt::format("<p class=\"caption\">{} of {} late: over {:.4g} ms, {}.{}</p>", late_.late,
                              late_.responses, to_millis(late_.late_over).count(),
                              late_.bound ? "the bound" : "the 99th percentile, since it has no bound", by_cause));
    for (std::size_t i = 0; i < shown_; ++i) add(late_.worst[i]);
    if (shown_ > 0) add_legend();
    page_.element("</div>");
  }

 private:
  std::string name(NodeId node) const { return story_.app.graph.node(node).name; }

  void add(const why::Response& response) {
    const Sums sums = sums_of(response);
    const double at_s = in_seconds(response.begin - started_);
    const std::string cause =
        response.cause ? why::in_words(*response.cause, story_.app.graph) : std::string("not late");
    page_.element(fmt::format("<details><summary><strong>{} ms</strong> at {:.3f} s: {}{}</summary>",
                              ms_text(response.length()), at_s, escaped(cause), bar(response, sums)));
    const auto micros = [&](TimePoint time) {
      return std::chrono::floor<std::chrono::microseconds>(time - started_).count();
    };
    const Micros margin = micros(started_ + response.length()) / 4;
    page_.element(
        fmt::format("<p class=\"live-only\"><button type=\"button\" data-from=\"{}\" data-to=\"{}\">Show it in the "
                    "charts</button></p>",
                    micros(response.begin) - margin, micros(response.end) + margin));
    page_.table(parts_table(sums));
    page_.element("</details>");
  }

  std::string bar(const why::Response& response, const Sums& sums) {
    std::string label;
    for (std::size_t i = 0; i < std::min(sums.size(), kMaxParts); ++i) {
      label += fmt::format("{}{} {} {} ms", i > 0 ? ", " : "", why::to_string(sums[i].first.first),
                           name(sums[i].first.second), ms_text(sums[i].second));
    }
    const auto longest = static_cast<double>(late_.worst.front().length().count());
    std::string text = fmt::format("<span class=\"bar\" role=\"img\" aria-label=\"{}\" style=\"width:{:.2f}%\">",
                                   escaped(label), 100.0 * static_cast<double>(response.length().count()) / longest);
    for (const Stretch& stretch : bar_of(response, columns_)) {
      const why::Part& part = stretch.part;
      used_[static_cast<std::size_t>(part.kind)] = true;
      const bool has_room = 12 * stretch.columns >= columns_;
      text += fmt::format("<span class=\"part {}\" style=\"flex-grow:{}\">{}</span>", why::to_string(part.kind),
                          stretch.columns, has_room ? escaped(name(why::whose(part).second)) : "");
    }
    return text + "</span>";
  }

  report::Table parts_table(const Sums& sums) const {
    report::Table table{.header = {"part", "node, or by which", "ms", "usual ms"}};
    Nanos rest{0};
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const auto& [whose, length] = sums[i];
      if (i >= kMaxParts) {
        rest += length;
        continue;
      }
      table.rows.push_back({why::to_string(whose.first), name(whose.second), ms_text(length), ms_text(usual(whose))});
    }
    if (rest > Nanos{0}) table.rows.push_back({"all others", "", ms_text(rest), ""});
    return table;
  }

  Nanos usual(const std::pair<why::PartKind, NodeId>& whose) const {
    for (const why::UsualPart& part : late_.usual) {
      if (part.kind == whose.first && part.node == whose.second) return part.median;
    }
    return Nanos{0};
  }

  void add_legend() {
    std::string text = "<p class=\"legend\">";
    for (std::size_t kind = 0; kind < used_.size(); ++kind) {
      if (!used_[kind]) continue;
      const char* const word = why::to_string(static_cast<why::PartKind>(kind));
      text += fmt::format("<span><span class=\"swatch part {}\"></span>{}</span> ", word, word);
    }
    page_.element(text + "</p>");
  }

  report::Page& page_;
  const Story& story_;
  const why::Analysis& late_;
  TimePoint started_;
  std::size_t shown_ = 0;
  std::size_t columns_ = 0;                   // of a bar
  std::array<bool, why::kPartKinds> used_{};  // in any of the bars
};

}  // namespace

std::vector<Stretch> bar_of(const why::Response& response, std::size_t columns) {
  std::vector<Stretch> bar;
  const Nanos length = response.length();
  const auto begin_of = [&](std::size_t column) {
    const double part = static_cast<double>(column) / static_cast<double>(columns);
    return response.begin + Nanos{static_cast<Nanos::rep>(part * static_cast<double>(length.count()))};
  };
  auto next = response.parts.begin();
  for (std::size_t column = 0; column < columns && next != response.parts.end(); ++column) {
    const TimePoint begin = begin_of(column);
    const TimePoint end = begin_of(column + 1);
    while (next->end <= begin && next + 1 != response.parts.end()) ++next;
    const why::Part* longest = &*next;
    Nanos max{0};
    for (auto part = next; part != response.parts.end() && part->begin < end; ++part) {
      const Nanos shared = std::min(part->end, end) - std::max(part->begin, begin);
      if (shared <= max) continue;
      max = shared;
      longest = &*part;
    }
    const bool goes_on = !bar.empty() && bar.back().part.kind == longest->kind &&
                         bar.back().part.node == longest->node && bar.back().part.by == longest->by;
    if (goes_on) {
      ++bar.back().columns;
    } else {
      bar.push_back({*longest, 1});
    }
  }
  return bar;
}

void add_late(report::Page& page, const Story& story, std::size_t chain) {
  const std::optional<why::Analysis>& late = story.figures.chains[chain].late;
  if (!late || late->responses == 0) return;
  Late(page, story, *late).write();
}

}  // namespace ctn::page
