#include "page/graph_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/escape.h"

namespace ctn::page {
namespace {

constexpr double kLetter = 6.7;  // a letter's width, about
constexpr double kBoxHeight = 44.0;
constexpr double kRowHeight = 84.0;
constexpr double kGap = 46.0;  // between columns, for the edges
constexpr double kMargin = 16.0;

// Characters, not bytes.
std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::vector<std::size_t> columns_of(const graph::Graph& graph) {
  std::vector<std::size_t> columns(graph.nodes().size());
  for (const NodeId id : graph.topological_order()) {
    for (const NodeId from : graph.node(id).predecessors) {
      columns[id.index()] = std::max(columns[id.index()], columns[from.index()] + 1);
    }
  }
  return columns;
}

// What stays together in a row: the nodes of a subchain, or one node.
std::vector<std::vector<NodeId>> groups_of(const graph::Graph& graph) {
  std::vector<std::vector<NodeId>> groups;
  std::vector<bool> done(graph.nodes().size());
  for (const NodeId id : graph.topological_order()) {
    if (done[id.index()]) continue;
    const auto subchain = graph.node(id).subchain;
    groups.push_back(subchain ? graph.subchain(*subchain).nodes : std::vector<NodeId>{id});
    for (const NodeId member : groups.back()) done[member.index()] = true;
  }
  return groups;
}

class Picture {
 public:
  Picture(const graph::Graph& graph, const std::vector<std::string>& notes, const std::vector<std::string>& colours)
      : graph_(graph), notes_(notes), colours_(colours), cells_(lay_out(graph)) {
    std::vector<double> widths;
    std::size_t rows = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      widths.resize(std::max(widths.size(), cells_[i].column + 1));
      widths[cells_[i].column] = std::max(widths[cells_[i].column], width(i));
      rows = std::max(rows, cells_[i].row + 1);
    }
    double x = kMargin;
    for (const double one : widths) {
      left_.push_back(x);
      x += one + kGap;
    }
    width_ = x - kGap + kMargin;
    height_ = static_cast<double>(rows) * kRowHeight + kMargin;
    column_widths_ = std::move(widths);
  }

  std::string svg() const {
    std::string text = fmt::format(
        "<svg class=\"graph\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" "
        "aria-label=\"{2}\">\n<defs><marker id=\"arrow\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" "
        "markerUnits=\"userSpaceOnUse\" markerWidth=\"9\" markerHeight=\"9\" orient=\"auto\"><path d=\"M0 0L8 4L0 "
        "8z\"/></marker></defs>\n",
        width_, height_, report::escaped(described()));
    for (const graph::Subchain& subchain : graph_.subchains()) text += group(subchain);
    for (const graph::Edge& edge : graph_.edges()) text += line(edge);
    for (std::size_t i = 0; i < cells_.size(); ++i) text += box(i);
    return text + "</svg>";
  }

 private:
  double width(std::size_t node) const {
    const std::size_t max = std::max(letters(graph_.nodes()[node].name), letters(notes_[node]));
    return std::max(64.0, kLetter * static_cast<double>(max) + 22.0);
  }
  double x(std::size_t node) const { return left_[cells_[node].column]; }
  double y(std::size_t node) const { return kMargin + 18.0 + static_cast<double>(cells_[node].row) * kRowHeight; }

  std::string described() const {
    std::string text = "The app's graph: ";
    for (const graph::Edge& edge : graph_.edges()) {
      text += fmt::format("{} to {}; ", graph_.node(edge.from).name, graph_.node(edge.to).name);
    }
    return text;
  }

  std::string group(const graph::Subchain& subchain) const {
    if (subchain.implicit) return {};
    const std::size_t head = subchain.head().index();
    const std::size_t tail = subchain.tail().index();
    return fmt::format(
        "<rect class=\"group\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"10\"/>"
        "<text class=\"group\" x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n",
        x(head) - 9, y(head) - 24, x(tail) + width(tail) - x(head) + 18, kBoxHeight + 34, x(head) - 1, y(head) - 9,
        report::escaped(subchain.name));
  }

  // Whether one triggers the other: they are neighbours in a subchain.
  bool triggers(const graph::Edge& edge) const {
    const auto subchain = graph_.node(edge.from).subchain;
    if (!subchain) return false;
    const std::vector<NodeId>& nodes = graph_.subchain(*subchain).nodes;
    const auto from = std::find(nodes.begin(), nodes.end(), edge.from);
    return from != nodes.end() && from + 1 != nodes.end() && *(from + 1) == edge.to;
  }

  std::string line(const graph::Edge& edge) const {
    const std::size_t from = edge.from.index();
    const std::size_t to = edge.to.index();
    const double x0 = x(from) + width(from);
    const double y0 = y(from) + kBoxHeight / 2;
    const double x1 = x(to) - 1;
    const double y1 = y(to) + kBoxHeight / 2;
    // Along the row: from its head to its tail a subchain has the row to itself.
    if (triggers(edge)) {
      return fmt::format(
          "<path class=\"edge triggers\" d=\"M{:.0f} {:.0f}L{:.0f} {:.0f}\" marker-end=\"url(#arrow)\"/>\n", x0, y0, x1,
          y1);
    }
    // Past the boxes of the columns between, through the gap between two rows.
    if (cells_[to].column > cells_[from].column + 1) {
      const double bend = kGap * 0.8;
      const double by = cells_[to].row > cells_[from].row ? y1 - kBoxHeight / 2 - 14.0 : y0 + kBoxHeight / 2 + 12.0;
      const double first = left_[cells_[from].column] + column_widths_[cells_[from].column];
      return fmt::format(
          "<path class=\"edge\" d=\"M{:.0f} {:.0f}C{:.0f} {:.0f} {:.0f} {:.0f} {:.0f} {:.0f}L{:.0f} {:.0f}C{:.0f} "
          "{:.0f} "
          "{:.0f} {:.0f} {:.0f} {:.0f}\" marker-end=\"url(#arrow)\"/>\n",
          x0, y0, x0 + bend / 2, y0, first + kGap / 2 - 10, by, first + kGap, by, left_[cells_[to].column] - kGap, by,
          x1 - kGap / 2, by, x1 - bend / 2, y1, x1, y1);
    }
    const double bend = (x1 - x0) / 2;
    return fmt::format(
        "<path class=\"edge\" d=\"M{:.0f} {:.0f}C{:.0f} {:.0f} {:.0f} {:.0f} {:.0f} {:.0f}\" "
        "marker-end=\"url(#arrow)\"/>\n",
        x0, y0, x0 + bend, y0, x1 - bend, y1, x1, y1);
  }

  std::string box(std::size_t i) const {
    const graph::Node& node = graph_.nodes()[i];
    const char* const kind = node.external ? " external" : node.unscheduled ? " unscheduled" : "";
    const double middle = x(i) + width(i) / 2;
    std::string text =
        fmt::format("<rect class=\"node{}\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"6\"/>",
                    kind, x(i), y(i), width(i), kBoxHeight);
    if (!colours_[i].empty()) {
      text += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"5\" height=\"{:.0f}\" rx=\"2\" fill=\"{}\"/>",
                          x(i) + 1, y(i) + 7, kBoxHeight - 14, colours_[i]);
    }
    const bool two = !notes_[i].empty();
    text += fmt::format("<text class=\"name\" x=\"{:.0f}\" y=\"{:.0f}\">{}</text>", middle, y(i) + (two ? 19 : 27),
                        report::escaped(node.name));
    if (two) {
      text += fmt::format("<text class=\"note\" x=\"{:.0f}\" y=\"{:.0f}\">{}</text>", middle, y(i) + 35,
                          report::escaped(notes_[i]));
    }
    return text + "\n";
  }

  const graph::Graph& graph_;
  const std::vector<std::string>& notes_;
  const std::vector<std::string>& colours_;
  std::vector<Cell> cells_;
  std::vector<double> left_;  // of columns
  std::vector<double> column_widths_;
  double width_ = 0.0;
  double height_ = 0.0;
};

}  // namespace

std::vector<Cell> lay_out(const graph::Graph& graph) {
  const std::vector<std::size_t> columns = columns_of(graph);
  std::vector<Cell> cells(columns.size());
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> rows;  // the stretches that are taken in each
  std::vector<bool> placed(columns.size());
  for (const std::vector<NodeId>& group : groups_of(graph)) {
    const std::size_t first = columns[group.front().index()];
    const std::size_t last = columns[group.back().index()];
    double sum = 0.0;
    double fed_by = 0.0;
    for (const NodeId node : group) {
      for (const NodeId from : graph.node(node).predecessors) {
        if (!placed[from.index()]) continue;
        sum += static_cast<double>(cells[from.index()].row);
        fed_by += 1.0;
      }
    }
    const double wanted = fed_by > 0.0 ? sum / fed_by : 0.0;
    std::size_t best = rows.size();
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const bool free = std::none_of(rows[row].begin(), rows[row].end(),
                                     [&](const auto& taken) { return taken.first <= last && first <= taken.second; });
      const auto distance = [&](std::size_t one) { return std::abs(static_cast<double>(one) - wanted); };
      if (free && (best == rows.size() || distance(row) < distance(best))) best = row;
    }
    if (best == rows.size()) rows.emplace_back();
    rows[best].emplace_back(first, last);
    for (const NodeId node : group) {
      cells[node.index()] = {columns[node.index()], best};
      placed[node.index()] = true;
    }
  }
  return cells;
}

std::string graph_picture(const graph::Graph& graph, const std::vector<std::string>& notes,
                          const std::vector<std::string>& colours) {
  return Picture(graph, notes, colours).svg();
}

}  // namespace ctn::page
