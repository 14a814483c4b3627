#include "top_table.h"

#include <algorithm>

namespace ctn::tool {
namespace {

constexpr std::size_t kMinName = 24;

// Where each character begins, and where the text ends.
std::vector<std::size_t> character_starts(const std::string& text) {
  std::vector<std::size_t> starts;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if ((static_cast<unsigned char>(text[at]) & 0xc0U) != 0x80U) starts.push_back(at);
  }
  starts.push_back(text.size());
  return starts;
}

}  // namespace

std::size_t screen_width(const std::string& text) { return character_starts(text).size() - 1; }

std::string shortened(const std::string& text, std::size_t width, bool unicode) {
  const std::vector<std::size_t> starts = character_starts(text);
  const std::size_t length = starts.size() - 1;
  if (length <= width) return text;
  if (width < 3) return text.substr(0, starts[width]);
  const std::size_t front = (width - 1) / 2;
  const std::size_t back = width - 1 - front;
  return text.substr(0, starts[front]) + (unicode ? "…" : "~") + text.substr(starts[length - back]);
}

ScreenLine cut_off(ScreenLine line, std::size_t width) {
  ScreenLine result;
  for (Span& span : line) {
    if (width == 0) break;
    const std::vector<std::size_t> starts = character_starts(span.text);
    const std::size_t kept = std::min(width, starts.size() - 1);
    span.text.resize(starts[kept]);
    width -= kept;
    result.push_back(std::move(span));
  }
  return result;
}

void ScreenTable::add(std::vector<Span> cells, bool selected) { rows_.push_back({std::move(cells), selected}); }

std::size_t ScreenTable::natural_width(std::size_t column) const {
  std::size_t width = screen_width(columns_[column].heading);
  for (const Row& row : rows_) {
    if (column < row.cells.size()) width = std::max(width, screen_width(row.cells[column].text));
  }
  return width;
}

std::vector<ScreenLine> ScreenTable::lines(std::size_t width, bool unicode) const {
  std::vector<std::size_t> widths;
  for (std::size_t column = 0; column < columns_.size(); ++column) widths.push_back(natural_width(column));
  std::vector<std::size_t> shown(columns_.size());
  for (std::size_t column = 0; column < shown.size(); ++column) shown[column] = column;
  std::size_t gap = 2;
  // Without the first column.
  const auto figures = [&] {
    std::size_t sum = 0;
    for (const std::size_t column : shown) sum += column == 0 ? 0 : widths[column] + gap;
    return sum;
  };
  const std::size_t min_name = std::min(widths[0], kMinName);
  if (figures() + widths[0] > width) gap = 1;
  while (figures() + min_name > width) {
    const auto min = std::max_element(
        shown.begin(), shown.end(), [&](std::size_t a, std::size_t b) { return columns_[a].rank < columns_[b].rank; });
    if (columns_[*min].rank == 0) break;
    shown.erase(min);
  }
  const std::size_t taken = std::min(figures(), width);
  widths[0] = std::min(widths[0], std::max(width - taken, std::min<std::size_t>(width, 4)));

  const auto line_of = [&](const auto& span_of, Style gaps) {
    ScreenLine line;
    for (const std::size_t column : shown) {
      Span span = span_of(column);
      if (column == 0) span.text = shortened(span.text, widths[0], unicode);
      const std::string padding(widths[column] - std::min(widths[column], screen_width(span.text)), ' ');
      if (column == 0) {
        span.text += padding;
      } else {
        line.push_back({std::string(gap, ' ') + padding, gaps});
      }
      line.push_back(std::move(span));
    }
    return cut_off(std::move(line), width);
  };
  std::vector<ScreenLine> result;
  result.push_back(line_of(
      [&](std::size_t column) {
        return Span{columns_[column].heading, Style::kHeading};
      },
      Style::kHeading));
  for (const Row& row : rows_) {
    result.push_back(line_of(
        [&](std::size_t column) {
          Span span = column < row.cells.size() ? row.cells[column] : Span{};
          if (row.selected) span.style = Style::kSelected;
          return span;
        },
        row.selected ? Style::kSelected : Style::kPlain));
  }
  return result;
}

}  // namespace ctn::tool
