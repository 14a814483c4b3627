#include "planner/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ctn::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

std::vector<int> members_of(const Set& set) {
  std::vector<int> members;
  for (const int i : set) members.push_back(i);
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
      piece.set |= Set::of(i);
      piece.kind = allocation.kind[i];
    } else {
      pieces.push_back({Set::of(i), allocation.owned[i], allocation.kind[i]});
    }
  }
  return pieces;
}

PriceMemory::Entry& PriceMemory::place_of(const Set& set) {
  std::size_t at = set.hash();
  for (;; ++at) {
    Entry& entry = entries_[at & (entries_.size() - 1)];
    if (entry.set.empty() || entry.set == set) return entry;
  }
}

void PriceMemory::grow() {
  std::vector<Entry> before = std::move(entries_);
  entries_.assign(std::max<std::size_t>(256, 2 * before.size()), {});
  for (const Entry& entry : before) {
    if (!entry.set.empty()) place_of(entry.set) = entry;
  }
}

PriceMemory::Place PriceMemory::at(const Set& set) {
  if (2 * (used_ + 1) > entries_.size()) grow();
  Entry& entry = place_of(set);
  const bool fresh = entry.set.empty();
  if (fresh) {
    entry.set = set;
    ++used_;
  }
  return {entry.price, fresh};
}

void PriceMemory::clear() {
  std::fill(entries_.begin(), entries_.end(), Entry{});
  used_ = 0;
}

void Prices::refresh() {
  const SharesSolver::Prices& prices = solver_.prices();
  constant_ = prices.constant;
  weight_.clear();
  for (std::size_t i = 0; i < instance_.members.size(); ++i) {
    weight_.push_back(std::max(0.0, prices.period[i] + prices.execution[i]));
  }
  kinds_.resize(instance_.kinds.size());
  for (int kind = 0; kind < instance_.kind_count(); ++kind) {
    OfKind& on = kinds_[index(kind)];
    on.known.clear();
    on.root.clear();
    on.owned.clear();
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
  if (piece.set.single()) return of_owned(piece.set.first(), piece.cores, piece.kind);
  const PriceMemory::Place place = kinds_[index(piece.kind)].known.at(piece.set);
  if (place.fresh) {
    const std::size_t before = solver_.steps();
    const std::vector<int> members = members_of(piece.set);
    place.price = solver_.price_of_shared(members, piece.kind);
    steps_ += 1 + (members.size() + solver_.steps() - before) / 16;
  }
  return place.price;
}

double Prices::of_owned(int subchain, int cores, int kind) const {
  const std::vector<double>& owned = on(kind).owned[index(subchain)];
  return cores <= static_cast<int>(owned.size()) ? owned[index(cores - 1)] : kInfinity;
}

double Prices::simple(const Set& set, int kind) const {
  double sum = 0.0;
  for (const int i : set) sum += root(index(i), kind);
  return sum * sum;
}

double Prices::of_all(const std::vector<Piece>& pieces) {
  double sum = constant_;
  for (const Piece& piece : pieces) sum += of(piece);
  return sum;
}

}  // namespace ctn::planner
