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
  Allocation allocation = Allocation::none(subchains);
  for (const Piece& piece : pieces) {
    const std::vector<int> members = members_of(piece.set);
    if (members.size() == 1) {
      allocation.own(static_cast<std::size_t>(members.front()), piece.cores, piece.kind);
      continue;
    }
    ++allocation.shared_cores;
    for (const int i : members) allocation.share(static_cast<std::size_t>(i), piece.kind);
  }
  return allocation;
}

std::vector<Piece> to_pieces(const Allocation& allocation) {
  std::vector<Piece> pieces(static_cast<std::size_t>(allocation.shared_cores));
  for (std::size_t i = 0; i < allocation.core_of.size(); ++i) {
    if (allocation.core_of[i] >= 0) {
      Piece& piece = pieces[static_cast<std::size_t>(allocation.core_of[i])];
      piece.set |= Set{1} << i;
      piece.kind = allocation.kind[i];
    } else {
      pieces.push_back({Set{1} << i, allocation.owned[i], allocation.kind[i]});
    }
  }
  return pieces;
}

void Prices::refresh() {
  const SharesSolver::Prices& prices = solver_.prices();
  constant_ = prices.constant;
  weight_.clear();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    weight_.push_back(std::max(0.0, prices.period[i] + prices.execution[i]));
  }
  kinds_.assign(instance_.kinds.size(), {});
  for (int kind = 0; kind < instance_.kind_count(); ++kind) {
    OfKind& on = kinds_[index(kind)];
    for (std::size_t i = 0; i < instance_.members.size(); ++i) {
      const OnKind& member = instance_.members[i].on_kind(kind);
      on.root.push_back(std::sqrt(weight_[i] * member.cost / instance_.usable));
      std::vector<double>& owned = on.owned.emplace_back();
      for (int k = 1; k <= static_cast<int>(member.owned.size()); ++k) {
        owned.push_back(solver_.price_of_owned(static_cast<int>(i), k, kind));
      }
    }
  }
}

double Prices::of(const Piece& piece) {
  if (std::has_single_bit(piece.set)) return of_owned(std::countr_zero(piece.set), piece.cores, piece.kind);
  const auto [known, fresh] = kinds_[index(piece.kind)].known.try_emplace(piece.set, 0.0);
  if (fresh) known->second = solver_.price_of_shared(members_of(piece.set), piece.kind);
  return known->second;
}

double Prices::of_owned(int subchain, int cores, int kind) const {
  const std::vector<double>& owned = on(kind).owned[index(subchain)];
  return cores <= static_cast<int>(owned.size()) ? owned[index(cores - 1)] : kInfinity;
}

double Prices::simple(Set set, int kind) const {
  double sum = 0.0;
  for (Set rest = set; rest != 0; rest &= rest - 1) sum += root(index(std::countr_zero(rest)), kind);
  return sum * sum;
}

double Prices::of_all(const std::vector<Piece>& pieces) {
  double sum = constant_;
  for (const Piece& piece : pieces) sum += of(piece);
  return sum;
}

}  // namespace ctn::planner
