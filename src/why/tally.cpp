#include "why/tally.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace ctn::why {
namespace {

constexpr int kUnexplainedPart = 50;  // at most one part in so many
constexpr std::size_t kMinKept = 64;  // responses that are kept before the shorter ones are dropped

Nanos unexplained(const std::vector<Part>& parts) {
  Nanos sum{0};
  for (const Part& part : parts) sum += part.kind == PartKind::kUnexplained ? part.length() : Nanos{0};
  return sum;
}

// Seven bits a byte, the lowest first; the highest bit of a byte: more follow.
void pack(std::uint64_t number, std::string& to) {
  for (; number >= 0x80U; number >>= 7U) to.push_back(static_cast<char>(number | 0x80U));
  to.push_back(static_cast<char>(number));
}

void pack(NodeId node, std::string& to) { pack(node.index(), to); }
void pack(Nanos duration, std::string& to) { pack(static_cast<std::uint64_t>(duration.count()), to); }
void pack(const std::optional<NodeId>& node, std::string& to) { pack(node ? node->index() + 1 : 0, to); }

void pack(const Causes::Evidence& evidence, std::string& to) {
  pack(evidence.first, to);
  pack(evidence.sums.size(), to);
  for (const Causes::Sum& sum : evidence.sums) {
    pack(static_cast<std::uint64_t>(sum.key.first), to);
    pack(sum.key.second, to);
    pack(sum.length, to);
    pack(sum.held_up, to);
    pack(sum.robbed, to);
  }
  pack(evidence.excesses.size(), to);
  for (const Causes::Excess& excess : evidence.excesses) {
    pack(excess.waiting, to);
    pack(excess.node, to);
    pack(excess.length, to);
  }
}

// Takes what was packed from the front.
std::uint64_t unpack_number(std::string_view& from) {
  std::uint64_t number = 0;
  for (unsigned shift = 0;; shift += 7) {
    const auto byte = static_cast<unsigned char>(from.front());
    from.remove_prefix(1);
    number |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
    if (byte < 0x80U) return number;
  }
}

NodeId unpack_node(std::string_view& from) { return NodeId{unpack_number(from)}; }

Nanos unpack_duration(std::string_view& from) { return Nanos{static_cast<Nanos::rep>(unpack_number(from))}; }

std::optional<NodeId> unpack_optional(std::string_view& from) {
  const std::uint64_t number = unpack_number(from);
  return number > 0 ? std::optional(NodeId{number - 1}) : std::nullopt;
}

Causes::Evidence unpack(std::string_view& from) {
  Causes::Evidence evidence;
  evidence.first = unpack_node(from);
  evidence.sums.resize(unpack_number(from));
  for (Causes::Sum& sum : evidence.sums) {
    sum.key.first = static_cast<PartKind>(unpack_number(from));
    sum.key.second = unpack_node(from);
    sum.length = unpack_duration(from);
    sum.held_up = unpack_optional(from);
    sum.robbed = unpack_optional(from);
  }
  evidence.excesses.resize(unpack_number(from));
  for (Causes::Excess& excess : evidence.excesses) {
    excess.waiting = unpack_node(from);
    excess.node = unpack_node(from);
    excess.length = unpack_duration(from);
  }
  return evidence;
}

}  // namespace

Tally::Tally(std::size_t term, std::optional<Nanos> bound, const Lengths& lengths, std::size_t worst)
    : usually_late_(lengths.usually_late), worst_(worst) {
  analysis_.term = term;
  analysis_.bound = bound;
  analysis_.response_ms = lengths.response_ms;
  analysis_.late_over = lengths.late_over;
}

void Tally::add(Response response, const History& history) {
  Causes::Evidence evidence = Causes::evidence_of(response.parts);
  causes_.add(evidence);
  ++analysis_.responses;
  if (kUnexplainedPart * unexplained(response.parts) <= response.length()) ++analysis_.explained;
  response.late = response.length() > analysis_.late_over;
  if (response.late) {
    ++analysis_.late;
    Causes::find_excesses(response.parts, history, evidence);
    pack(evidence, late_);
  }
  if (worst_ == 0) return;
  longest_.push_back({std::move(response), std::move(evidence)});
  if (longest_.size() >= std::max(2 * worst_, kMinKept)) drop_shorter();
}

// The longest first; of those that are as long, the first ones.
void Tally::drop_shorter() {
  std::stable_sort(longest_.begin(), longest_.end(), [](const Kept& a, const Kept& b) {
    if (a.response.length() != b.response.length()) return a.response.length() > b.response.length();
    return a.response.end < b.response.end;
  });
  if (longest_.size() > worst_) longest_.erase(longest_.begin() + static_cast<std::ptrdiff_t>(worst_), longest_.end());
}

Analysis Tally::finish(const graph::Graph& graph) {
  for (const auto& [key, median] : causes_.medians()) analysis_.usual.push_back({key.first, key.second, median});
  std::stable_sort(analysis_.usual.begin(), analysis_.usual.end(),
                   [](const UsualPart& a, const UsualPart& b) { return a.median > b.median; });
  for (std::string_view left = late_; !left.empty();) {
    ++analysis_.causes[static_cast<std::size_t>(causes_.cause_of(unpack(left), graph, usually_late_).kind)];
  }
  drop_shorter();
  for (Kept& kept : longest_) {
    if (kept.response.late) {
      kept.response.cause = causes_.cause_of(kept.evidence, graph, usually_late_);
    }
    analysis_.worst.push_back(std::move(kept.response));
  }
  return std::move(analysis_);
}

}  // namespace ctn::why
