#include "planner/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

std::vector<int> members_of(Set set) {
  std::vector<int> members;
  for (; set != 0; set &= set - 1) members.push_back(std::countr_zero(set));
  return members;
}

Allocation to_allocation(const std::vector<Piece>& pieces, std::size_t subchains) {
  Allocation allocation;
  allocation.core_of.assign(subchains, -1);
  allocation.owned.assign(subchains, 0);
  for (const Piece& piece : pieces) {
    const std::vector<int> members = members_of(piece.set);
    if (members.size() == 1) {
      allocation.owned[static_cast<std::size_t>(members.front())] = piece.cores;
    } else {
      for (const int i : members) allocation.core_of[static_cast<std::size_t>(i)] = allocation.shared_cores;
      ++allocation.shared_cores;
    }
  }
  return allocation;
}

std::vector<Piece> to_pieces(const Allocation& allocation) {
  std::vector<Piece> pieces(static_cast<std::size_t>(allocation.shared_cores));
  for (std::size_t i = 0; i < allocation.core_of.size(); ++i) {
    if (allocation.core_of[i] >= 0) {
      pieces[static_cast<std::size_t>(allocation.core_of[i])].set |= Set{1} << i;
    } else {
      pieces.push_back({Set{1} << i, allocation.owned[i]});
    }
  }
  return pieces;
}

void Prices::refresh() {
  const SharesSolver::Prices& prices = solver_.prices();
  constant_ = prices.constant;
  known_.clear();
  weight_.clear();
  root_.clear();
  owned_.clear();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    const double weight = std::max(0.0, prices.period[i] + prices.execution[i]);
    weight_.push_back(weight);
    root_.push_back(std::sqrt(weight * instance_.members[i].cost / instance_.usable));
    std::vector<double>& owned = owned_.emplace_back();
    for (int k = 1; k <= static_cast<int>(instance_.members[i].owned.size()); ++k) {
      owned.push_back(solver_.price_of_owned(static_cast<int>(i), k));
    }
  }
}

double Prices::of(const Piece& piece) {
  if (std::has_single_bit(piece.set)) return of_owned(std::countr_zero(piece.set), piece.cores);
  const auto [known, fresh] = known_.try_emplace(piece.set, 0.0);
  if (fresh) known->second = solver_.price_of_shared(members_of(piece.set));
  return known->second;
}

double Prices::of_owned(int subchain, int cores) const {
  const std::vector<double>& owned = owned_[static_cast<std::size_t>(subchain)];
  return cores <= static_cast<int>(owned.size()) ? owned[static_cast<std::size_t>(cores - 1)] : kInfinity;
}

double Prices::simple(Set set) const {
  double sum = 0.0;
  for (Set rest = set; rest != 0; rest &= rest - 1) sum += root_[static_cast<std::size_t>(std::countr_zero(rest))];
  return sum * sum;
}

double Prices::of_all(const std::vector<Piece>& pieces) {
  double sum = constant_;
  for (const Piece& piece : pieces) sum += of(piece);
  return sum;
}

}  // namespace ctn::planner
