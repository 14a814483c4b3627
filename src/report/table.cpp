#include "report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace ctn::report {
namespace {

// "12.5", "-3 ms", "99 %", "1.2e3 Hz", empty or a dash.
bool numeric(const std::string& cell) {
  if (cell.empty() || cell == "-" || cell == "–" || cell == "—") return true;
  std::size_t at = cell.front() == '-' || cell.front() == '+' ? 1 : 0;
  if (at == cell.size() || std::isdigit(static_cast<unsigned char>(cell[at])) == 0) return false;
  while (at < cell.size() && cell[at] != ' ') {
    const char c = cell[at++];
    if (std::isdigit(static_cast<unsigned char>(c)) == 0 && std::string_view(".,eE+-%").find(c) == std::string::npos) {
      return false;
    }
  }
  return cell.size() - at <= 7;  // room for a unit
}

// On a terminal; counts characters, not bytes.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

const std::string& cell(const std::vector<std::string>& row, std::size_t column) {
  static const std::string kEmpty;
  return column < row.size() ? row[column] : kEmpty;
}

}  // namespace

bool numeric_column(const Table& table, std::size_t column) {
  return !table.rows.empty() && std::all_of(table.rows.begin(), table.rows.end(), [&](const auto& row) {
    return column >= row.size() || numeric(row[column]);
  });
}

std::string to_text(const Table& table, Align align) {
  std::vector<std::vector<std::string>> rows{table.header};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  std::vector<std::string> lines(rows.size(), " ");
  for (std::size_t column = 0; column < table.header.size(); ++column) {
    const auto filled = [&](const auto& row) { return !cell(row, column).empty(); };
    if (std::none_of(table.rows.begin(), table.rows.end(), filled)) continue;
    std::size_t widest = 0;
    for (const auto& row : rows) widest = std::max(widest, width(cell(row, column)));
    const bool right = align == Align::kNumbersRight && numeric_column(table, column);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::string padding(widest - width(cell(rows[i], column)), ' ');
      lines[i] += right ? " " + padding + cell(rows[i], column) + " " : " " + cell(rows[i], column) + padding + " ";
    }
  }
  std::string text;
  for (std::string& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace ctn::report
