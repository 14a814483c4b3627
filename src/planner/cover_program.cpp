#include "planner/cover_program.h"

#include <algorithm>

namespace ctn::planner {
namespace {

constexpr double kWorthwhile = 1e-10;  // of the largest price: what a pivot must gain
constexpr double kLeastPivot = 1e-9;
constexpr double kUntied = 1e-7;
constexpr std::size_t kStep = 1'000;  // numbers looked at in one step of effort

}  // namespace

// At first each subchain has a stand-in that takes no core and costs its most, and all cores are idle. The right-hand
// sides are a little more than one, each by its own amount: no two rows tie, and no pivot is in vain.
CoverProgram::CoverProgram(const std::vector<double>& most, int cores) {
  const std::size_t count = most.size();
  prices_.members = most;
  inverse_.assign(rows() * rows(), 0.0);
  for (std::size_t row = 0; row < rows(); ++row) inverse(row)[row] = 1.0;
  for (std::size_t i = 0; i < count; ++i) {
    columns_.push_back({{Set::of(i), 0}, most[i]});
    level_.push_back(1.0 + kUntied * (1.0 + static_cast<double>(i * 7919 % 101) / 101.0));
  }
  columns_.push_back({{Set{}, 1}, 0.0});
  level_.push_back(cores);
  basic_cost_ = most;
  basic_cost_.push_back(0.0);
}

void CoverProgram::price() {
  const std::size_t count = prices_.members.size();
  std::fill(prices_.members.begin(), prices_.members.end(), 0.0);
  prices_.core = 0.0;
  for (std::size_t row = 0; row < rows(); ++row) {
    const double cost = basic_cost_[row];
    if (cost == 0.0) continue;
    const double* of_row = inverse(row);
    for (std::size_t i = 0; i < count; ++i) prices_.members[i] += cost * of_row[i];
    prices_.core -= cost * of_row[count];
  }
}

std::size_t CoverProgram::entering() const {
  double least = -kWorthwhile * *std::max_element(prices_.members.begin(), prices_.members.end());
  std::size_t chosen = kNone;
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const double reduced = columns_[j].reduced(prices_);
    if (reduced >= least) continue;
    least = reduced;
    chosen = j;
  }
  return chosen;
}

// The row whose variable falls to zero first as the column enters.
std::size_t CoverProgram::leaving(const Column& column) {
  direction_.resize(rows());
  std::size_t chosen = kNone;
  double room = 0.0;
  for (std::size_t row = 0; row < rows(); ++row) {
    const double* of_row = inverse(row);
    double sum = column.piece.cores * of_row[rows() - 1];
    for (const int i : column.piece.set) sum += of_row[i];
    direction_[row] = sum;
    if (sum <= kLeastPivot) continue;
    const double until = std::max(0.0, level_[row]) / sum;
    if (chosen != kNone && until >= room) continue;
    chosen = row;
    room = until;
  }
  return chosen;
}

void CoverProgram::pivot(std::size_t row, double cost) {
  double* pivot_row = inverse(row);
  for (std::size_t c = 0; c < rows(); ++c) pivot_row[c] /= direction_[row];
  level_[row] = std::max(0.0, level_[row]) / direction_[row];
  basic_cost_[row] = cost;
  for (std::size_t other = 0; other < rows(); ++other) {
    const double times = direction_[other];
    if (other == row || times == 0.0) continue;
    double* of_row = inverse(other);
    for (std::size_t c = 0; c < rows(); ++c) of_row[c] -= times * pivot_row[c];
    level_[other] -= times * level_[row];
  }
}

std::size_t CoverProgram::solve(std::size_t most_pivots) {
  std::size_t pivots = 0;
  price();
  for (; pivots < most_pivots; ++pivots) {
    const std::size_t column = entering();
    if (column == kNone) break;
    const std::size_t row = leaving(columns_[column]);
    if (row == kNone) break;
    pivot(row, columns_[column].cost);
    price();
  }
  prices_.core = std::max(0.0, prices_.core);
  return (pivots + 1) * (1 + (columns_.size() + rows() * rows()) / kStep);
}

}  // namespace ctn::planner
