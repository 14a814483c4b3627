#include "planner/local_search.h"

#include <algorithm>
#include <tuple>

namespace ctn::planner {
namespace {

constexpr std::size_t kLooksAStep = 128;  // of effort
constexpr std::size_t kLooksAChange = 8;  // at each piece
// Of the exchanges between two groups at first, those that roots promise most of; in each search after that of one
// object twice as many.
constexpr std::size_t kPriced = 2;
constexpr double kRounding = 1e-9;  // of what groups cost at least

void drop_empty(std::vector<Piece>& pieces) {
  std::erase_if(pieces, [](const Piece& piece) { return piece.set.empty(); });
}

}  // namespace

LocalSearch::LocalSearch(const Instance& instance, Prices& prices)
    : instance_(instance), prices_(prices), by_work_(instance.members.size() > kCheap) {
  const bool rates = std::any_of(instance.members.begin(), instance.members.end(), [](const Member& member) {
    return member.min_period > 0.0 || member.exact_period > 0.0;
  });
  ruled_ = by_work_ || !rates ? 1.0 - kRounding : 0.0;
}

std::vector<Piece> LocalSearch::start() const {
  std::vector<int> cores;
  for (const CoreKind& kind : instance_.kinds) cores.push_back(kind.count);
  return start(Set::up_to(instance_.members.size()), cores);
}

std::vector<Piece> LocalSearch::start(const Set& some, const std::vector<int>& given) const {
  std::vector<std::size_t> order;
  for (const int i : some) order.push_back(static_cast<std::size_t>(i));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return root(a) > root(b); });
  std::vector<Core> cores;
  for (int kind = 0; kind < instance_.kind_count(); ++kind) {
    const int most = std::min(static_cast<int>(order.size()), given[static_cast<std::size_t>(kind)]);
    for (int core = 0; core < most; ++core) cores.push_back({{{}, 1, kind}, 0.0});
  }
  if (cores.empty()) return {};
  for (const std::size_t i : order) {
    Core& best = *std::min_element(cores.begin(), cores.end(),
                                   [&](const Core& a, const Core& b) { return promise(i, a) < promise(i, b); });
    best.piece.set |= Set::of(i);
    best.load += prices_.root(i, best.piece.kind);
  }
  std::vector<Piece> pieces;
  for (const Core& core : cores) pieces.push_back(core.piece);
  drop_empty(pieces);
  return pieces;
}

void LocalSearch::improve(std::vector<Piece>& pieces, Effort& effort) {
  known_.clear();
  settled_.clear();
  looks_ = 0;
  paid_ = prices_.steps();
  priced_ = std::max(kPriced, 2 * priced_);
  bool better = true;
  while (better && effort.left > 0) {
    better = give_spare_cores(pieces);
    better = move_or_swap(pieces, effort) || better;
    better = merge_and_give(pieces, effort) || better;
  }
}

bool LocalSearch::pay(Effort& effort, std::size_t fixed, std::size_t looks) {
  if (!by_work_) return effort.spend(fixed);
  looks_ += looks;
  const std::size_t work = prices_.steps() + looks_ / kLooksAStep;
  const std::size_t due = work - paid_;
  paid_ = work;
  return effort.spend(due);
}

// Of all kinds: on the one where it is least.
double LocalSearch::root(std::size_t i) const {
  double least = prices_.root(i, 0);
  for (int kind = 1; kind < instance_.kind_count(); ++kind) least = std::min(least, prices_.root(i, kind));
  return least;
}

double LocalSearch::roots(const Set& set, int kind) const {
  double sum = 0.0;
  for (const int i : set) sum += prices_.root(static_cast<std::size_t>(i), kind);
  return sum;
}

// What a core's load would be with it; where all are alike an empty core comes first, however small the loads.
std::pair<bool, double> LocalSearch::promise(std::size_t i, const Core& core) const {
  const bool alike = instance_.kind_count() == 1;
  return {alike && !core.piece.set.empty(), alike ? core.load : core.load + prices_.root(i, core.piece.kind)};
}

int LocalSearch::spare(const std::vector<Piece>& pieces, int kind) const {
  int left = instance_.kind(kind).count;
  for (const Piece& piece : pieces) left -= piece.kind == kind ? piece.cores : 0;
  return left;
}

// ---- Cores given

LocalSearch::Known& LocalSearch::known(const Piece& piece) {
  const auto [at, fresh] = known_.try_emplace(piece);
  if (fresh) {
    at->second.number = static_cast<std::uint32_t>(known_.size());
    at->second.gifts.resize(instance_.kinds.size());
  }
  return at->second;
}

const LocalSearch::Gift& LocalSearch::gift(const Piece& piece, int kind) {
  std::optional<Gift>& gift = known(piece).gifts[static_cast<std::size_t>(kind)];
  if (!gift) gift = best_use(piece, kind);
  return *gift;
}

// For one that owns cores of the kind, for a member of a shared core, or for all that share one of another kind.
LocalSearch::Gift LocalSearch::best_use(const Piece& piece, int kind) {
  Gift best;
  const double now = price(piece);
  const auto look = [&](const Piece& to, const Piece& rest) {
    const double gain = now - price(to) - price(rest);
    if (gain > best.gain && clearly(gain, now)) best = {gain, piece, to, rest};
  };
  if (piece.kind != kind && piece.cores == 1) look({piece.set, 1, kind}, {});
  if (piece.set.single()) {
    if (piece.kind == kind) look({piece.set, piece.cores + 1, kind}, {});
    return best;
  }
  const double sum = roots(piece.set, piece.kind);
  const bool two = piece.set.size() == 2;
  for (const int i : piece.set) {
    const double left = sum - prices_.root(static_cast<std::size_t>(i), piece.kind);
    const double least = two ? 0.0 : ruled_ * left * left;
    if (now - least - finite(prices_.of_owned(i, 1, kind)) < best.gain) continue;
    const Set one = Set::of(static_cast<std::size_t>(i));
    look({one, 1, kind}, {piece.set - one, 1, piece.kind});
  }
  return best;
}

// Of all kinds that there are spare cores of; null where there is nothing to gain.
const LocalSearch::Gift* LocalSearch::best_gift(const std::vector<Piece>& pieces) {
  const Gift* best = nullptr;
  for (int kind = 0; kind < instance_.kind_count(); ++kind) {
    if (spare(pieces, kind) <= 0) continue;
    for (const Piece& piece : pieces) {
      const Gift& of_piece = gift(piece, kind);
      if (of_piece.gain > (best ? best->gain : 0.0)) best = &of_piece;
    }
  }
  return best;
}

namespace {

template <class Gift>
void give(std::vector<Piece>& pieces, const Gift& gift) {
  *std::find(pieces.begin(), pieces.end(), gift.from) = gift.to;
  if (!gift.rest.set.empty()) pieces.push_back(gift.rest);
}

}  // namespace

bool LocalSearch::give_spare_cores(std::vector<Piece>& pieces) {
  bool given = false;
  for (const Gift* gift = best_gift(pieces); gift; gift = best_gift(pieces)) {
    give(pieces, *gift);
    given = true;
  }
  return given;
}

// ---- Moves and swaps

bool LocalSearch::move_or_swap(std::vector<Piece>& pieces, Effort& effort) {
  bool any = false;
  std::vector<std::uint32_t> numbers;
  for (const Piece& piece : pieces) numbers.push_back(known(piece).number);
  for (std::size_t g = 0; g < pieces.size(); ++g) {
    for (std::size_t h = 0; h < pieces.size(); ++h) {
      if (g == h || pieces[g].cores != 1 || pieces[h].cores != 1) continue;
      const bool swaps = h > g;
      const std::uint64_t pair = std::uint64_t{numbers[g]} << 32U | std::uint64_t{numbers[h]} << 1U | (swaps ? 1U : 0U);
      if (!pay(effort, 4, 1)) return any;
      // Two that are alone have nothing to exchange but their cores.
      const bool alone = pieces[g].set.single() && pieces[h].set.single() && pieces[g].kind == pieces[h].kind;
      if (alone || settled_.count(pair) > 0) continue;
      if (!better_pair(pieces[g], pieces[h], swaps, effort)) {
        settled_.insert(pair);
        continue;
      }
      any = true;
      numbers[g] = known(pieces[g]).number;
      numbers[h] = known(pieces[h]).number;
    }
  }
  // A core may be too slow to be of use.
  drop_empty(pieces);
  return any;
}

// The best move from one to the other, or, if `swaps`, exchange between them.
bool LocalSearch::better_pair(Piece& from, Piece& to, bool swaps, Effort& effort) {
  const double now = price(from) + price(to);
  const bool alike = from.kind == to.kind;
  double best = now;
  Set best_from = from.set;
  Set best_to = to.set;
  const auto look = [&](const Set& at_from, const Set& at_to) {
    if (alike && (at_from.empty() || at_to.empty())) return;
    const double then = price({at_from, 1, from.kind}) + price({at_to, 1, to.kind});
    if (then < best && clearly(best - then, now)) {
      best = then;
      best_from = at_from;
      best_to = at_to;
    }
  };
  if (!alike && swaps) look(to.set, from.set);
  const std::size_t from_size = from.set.size();
  const std::size_t to_size = to.set.size();
  const double from_roots = roots(from.set, from.kind);
  const double to_roots = roots(to.set, to.kind);
  // At least what a group costs that some leave and some join. One that is alone is not ruled out.
  const auto least = [this](double sum, std::size_t size) { return size > 1 ? ruled_ * sum * sum : 0.0; };
  struct Candidate {
    double least = 0.0;
    int leaves = 0;
    int joins = -1;
  };
  const auto try_candidate = [&](const Candidate& candidate) {
    const Set one = Set::of(static_cast<std::size_t>(candidate.leaves));
    if (candidate.joins < 0) return look(from.set - one, to.set | one);
    const Set two = Set::of(static_cast<std::size_t>(candidate.joins));
    look((from.set - one) | two, (to.set - two) | one);
  };
  std::vector<Candidate> later;
  const auto offer = [&](const Candidate& candidate) {
    if (candidate.least >= best) return;
    if (by_work_) {
      later.push_back(candidate);
    } else {
      try_candidate(candidate);
    }
  };
  for (const int i : from.set) {
    const auto index = static_cast<std::size_t>(i);
    const double without = from_roots - prices_.root(index, from.kind);
    const double with = to_roots + prices_.root(index, to.kind);
    offer({least(without, from_size - 1) + least(with, to_size + 1), i});
    if (!swaps) continue;
    for (const int j : to.set) {
      const auto other = static_cast<std::size_t>(j);
      const double at_from = without + prices_.root(other, from.kind);
      const double at_to = with - prices_.root(other, to.kind);
      offer({least(at_from, from_size) + least(at_to, to_size), i, j});
    }
  }
  const std::size_t most = std::min(later.size(), priced_);
  std::partial_sort(later.begin(), later.begin() + static_cast<std::ptrdiff_t>(most), later.end(),
                    [](const Candidate& x, const Candidate& y) {
                      return std::tie(x.least, x.leaves, x.joins) < std::tie(y.least, y.leaves, y.joins);
                    });
  for (std::size_t c = 0; c < most && later[c].least < best; ++c) try_candidate(later[c]);
  if (by_work_) pay(effort, 0, from_size * to_size);
  if (!(best < now)) return false;
  from.set = best_from;
  to.set = best_to;
  return true;
}

// ---- Cores taken

// Two groups on one core, and the core that this frees to whom it serves best; or one core less for an owner of
// several.
bool LocalSearch::merge_and_give(std::vector<Piece>& pieces, Effort& effort) {
  const double now = prices_.of_all(pieces);
  const Leaders leaders = this->leaders(pieces);
  for (std::size_t g = 0; g < pieces.size(); ++g) {
    if (pieces[g].cores > 1) {
      if (by_work_ && !pay(effort, 0, kLooksAChange * pieces.size())) return false;
      std::vector<Piece> changed = pieces;
      --changed[g].cores;
      if (accept(pieces, std::move(changed), now)) return true;
      continue;
    }
    for (std::size_t h = 0; h < pieces.size(); ++h) {
      if (h == g || pieces[h].cores > 1 || (h < g && pieces[h].kind == pieces[g].kind)) continue;
      if (!pay(effort, 16, 1)) return false;
      if (least_merged(pieces, g, h, leaders) >= price(pieces[g]) + price(pieces[h])) continue;
      if (by_work_ && !pay(effort, 0, kLooksAChange * pieces.size())) return false;
      std::vector<Piece> changed = pieces;
      changed[g].set |= changed[h].set;
      changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(h));
      if (accept(pieces, std::move(changed), now)) return true;
    }
  }
  return false;
}

LocalSearch::Leaders LocalSearch::leaders(const std::vector<Piece>& pieces) {
  constexpr std::size_t kLeaders = 3;
  Leaders leaders(instance_.kinds.size());
  for (int kind = 0; kind < instance_.kind_count(); ++kind) {
    if (instance_.kind(kind).count == 0) continue;
    std::vector<Leader>& of_kind = leaders[static_cast<std::size_t>(kind)];
    for (std::size_t i = 0; i < pieces.size(); ++i) of_kind.push_back({gift(pieces[i], kind).gain, i});
    const std::size_t most = std::min(kLeaders, of_kind.size());
    std::partial_sort(of_kind.begin(), of_kind.begin() + static_cast<std::ptrdiff_t>(most), of_kind.end(),
                      [](const Leader& a, const Leader& b) { return a.gain > b.gain; });
    of_kind.resize(most);
  }
  return leaders;
}

// At least what the two would cost on the core of the first, less what the best use of the other's core gains. A core
// of any kind might be spare.
double LocalSearch::least_merged(const std::vector<Piece>& pieces, std::size_t g, std::size_t h,
                                 const Leaders& leaders) const {
  const int kind = pieces[g].kind;
  const Set set = pieces[g].set | pieces[h].set;
  const double sum = roots(pieces[g].set, kind) + roots(pieces[h].set, kind);
  double elsewhere = 0.0;
  for (const std::vector<Leader>& of_kind : leaders) {
    const auto other = std::find_if(of_kind.begin(), of_kind.end(),
                                    [&](const Leader& leader) { return leader.piece != g && leader.piece != h; });
    if (other != of_kind.end()) elsewhere = std::max(elsewhere, other->gain);
  }
  double least = ruled_ * sum * sum - elsewhere * (1.0 + kRounding);
  const bool two = set.size() == 2;
  for (int to = 0; to < instance_.kind_count(); ++to) {
    if (instance_.kind(to).count == 0) continue;
    if (to != kind) {
      const double moved = roots(set, to);
      least = std::min(least, ruled_ * moved * moved);
    }
    for (const int i : set) {
      const double left = sum - prices_.root(static_cast<std::size_t>(i), kind);
      const double rest = two ? 0.0 : ruled_ * left * left;
      least = std::min(least, rest + finite(prices_.of_owned(i, 1, to)) * ruled_);
    }
  }
  return least;
}

bool LocalSearch::accept(std::vector<Piece>& pieces, std::vector<Piece> changed, double now) {
  const Gift* gift = best_gift(changed);
  if (!gift) return false;
  give(changed, *gift);
  const double then = prices_.of_all(changed);
  if (!(std::isfinite(then) && clearly(now - then, now))) return false;
  pieces = std::move(changed);
  return true;
}

}  // namespace ctn::planner
