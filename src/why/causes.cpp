#include "why/causes.h"

#include <algorithm>

namespace ctn::why {
namespace {

bool is_by_another(PartKind kind) { return kind == PartKind::kPreEmpted || kind == PartKind::kStolen; }

// What a subchain loses of its slots, or needs in addition, may make it wait up to this many times as long for the next
// ones.
constexpr int kSlotsPerLoss = 10;

// The node in whose slot the thief ran.
NodeId robbed(std::span<const Part> parts, NodeId thief) {
  for (const Part& part : parts) {
    if (part.kind == PartKind::kStolen && part.by == thief) return part.node;
  }
  return thief;
}

bool waits_for_trigger(PartKind kind) {
  return kind == PartKind::kWaitingForTrigger || kind == PartKind::kLateTrigger || kind == PartKind::kPlanChange ||
         kind == PartKind::kOwnPreviousRun;
}

CauseKind cause_by(PartKind kind) {
  switch (kind) {
    case PartKind::kWaitingForSample:
      return CauseKind::kWaitedForSample;
    case PartKind::kRunning:  // no run took longer than usual, so there were more runs on the way
    case PartKind::kWaitingForTrigger:
      return CauseKind::kWaitedForTrigger;
    case PartKind::kLateTrigger:
      return CauseKind::kLateTrigger;
    case PartKind::kLateTimer:
      return CauseKind::kLateTimer;
    case PartKind::kOwnPreviousRun:
      return CauseKind::kOwnPreviousRun;
    case PartKind::kPlanChange:
      return CauseKind::kPlanChange;
    case PartKind::kNoOutput:
      return CauseKind::kNoOutput;
    case PartKind::kWaitingForSlot:
      return CauseKind::kWaitedForSlot;
    case PartKind::kStolen:
      return CauseKind::kStolen;
    case PartKind::kPreEmpted:
      return CauseKind::kPreEmpted;
    case PartKind::kKernel:
      return CauseKind::kStarved;
    case PartKind::kRunningLonger:
      return CauseKind::kLongRun;
    case PartKind::kDevice:
      return CauseKind::kDevice;
    case PartKind::kWaitingForTick:
      return CauseKind::kWaitedForTick;
    case PartKind::kUnexplained:
      break;
  }
  return CauseKind::kUnexplained;
}

// Of the runs that ended in a stretch of own-previous-run, the one that exceeds what is usual by most.
std::pair<NodeId, Nanos> longest_excess(const Part& part, const History& history) {
  std::pair<NodeId, Nanos> longest{part.node, Nanos{0}};
  const graph::Graph& graph = history.app().graph;
  const std::optional<SubchainId> subchain = graph.node(part.node).subchain;
  const std::vector<NodeId> itself{part.node};
  for (const NodeId node : subchain ? graph.subchain(*subchain).nodes : itself) {
    for (std::optional<RunRef> run = history.last_ended(node, part.end, false);
         run && history.run(*run).end > part.begin; --run->index) {
      const Nanos excess = history.run(*run).cpu - history.usual_cpu(node);
      if (excess > longest.second) longest = {node, excess};
      if (run->index == 0) break;
    }
  }
  return longest;
}

}  // namespace

std::map<Causes::Key, Nanos> Causes::sums(std::span<const Part> parts) {
  std::map<Key, Nanos> sums;
  for (const Part& part : parts) sums[whose(part)] += part.length();
  return sums;
}

void Causes::add(std::span<const Part> parts) {
  ++responses_;
  for (const auto& [key, length] : sums(parts)) lengths_[key].push_back(length);
}

std::vector<std::pair<Causes::Key, Nanos>> Causes::medians() {
  const std::size_t rank = (responses_ + 1) / 2;  // from 1
  for (auto& [key, lengths] : lengths_) {
    const std::size_t without = responses_ - lengths.size();
    if (rank <= without) continue;
    const auto median = lengths.begin() + static_cast<std::ptrdiff_t>(rank - without - 1);
    std::nth_element(lengths.begin(), median, lengths.end());
    if (*median > Nanos{0}) medians_[key] = *median;
  }
  return {medians_.begin(), medians_.end()};
}

// By how much the parts of a key exceed what is usual of them. `usually_late`: by their whole length.
Nanos Causes::beyond_usual(const Key& key, const std::map<Key, Nanos>& lengths, bool usually_late) const {
  const auto in = [&](const std::map<Key, Nanos>& of) {
    const auto found = of.find(key);
    return found == of.end() ? Nanos{0} : found->second;
  };
  return in(lengths) - (usually_late ? Nanos{0} : in(medians_));
}

Cause Causes::cause_of(std::span<const Part> parts, const History& history, bool usually_late) const {
  const std::map<Key, Nanos> lengths = sums(parts);
  const auto beyond = [&](const Key& key) { return beyond_usual(key, lengths, usually_late); };
  // What waits for slots of the node's subchain exceed.
  const auto slots_beyond = [&](NodeId of) {
    const graph::Graph& graph = history.app().graph;
    Nanos sum{0};
    for (const auto& [key, length] : lengths) {
      if (key.first != PartKind::kWaitingForSlot) continue;
      if (key.second == of || (graph.node(of).subchain && graph.node(key.second).subchain == graph.node(of).subchain)) {
        sum += std::max(beyond(key), Nanos{0});
      }
    }
    return sum;
  };
  Key max{PartKind::kUnexplained, parts.empty() ? NodeId{} : parts.front().node};
  Nanos exceeded{0};
  for (const auto& [key, length] : lengths) {
    Nanos excess = beyond(key);
    if (key.first == PartKind::kPlanChange) {
      excess = Nanos{0};
      for (const PartKind kind :
           {PartKind::kWaitingForTrigger, PartKind::kLateTrigger, PartKind::kPlanChange, PartKind::kOwnPreviousRun}) {
        excess += beyond({kind, key.second});
      }
    } else if (waits_for_trigger(key.first) && lengths.contains({PartKind::kPlanChange, key.second})) {
      continue;
    } else if (key.first == PartKind::kStolen || key.first == PartKind::kRunningLonger) {
      const NodeId whose = key.first == PartKind::kStolen ? robbed(parts, key.second) : key.second;
      const Nanos slots = slots_beyond(whose);
      if (kSlotsPerLoss * excess >= slots) excess += slots;
    }
    if (excess > exceeded) {
      exceeded = excess;
      max = key;
    }
  }
  Cause cause{cause_by(max.first), max.second, {}, exceeded};
  if (usually_late && max.first == PartKind::kRunning) cause.kind = CauseKind::kLongRun;
  look_closer(parts, history, max, cause);
  return cause;
}

// At the parts of the key that exceeds what is usual by most: who pre-empted or stole whom, and whether a node's
// previous run was a long one.
void Causes::look_closer(std::span<const Part> parts, const History& history, const Key& max, Cause& cause) {
  Nanos longest{0};
  for (const Part& part : parts) {
    if (part.kind != max.first) continue;
    if (is_by_another(max.first) && part.by == max.second && part.length() > longest) {
      longest = part.length();
      cause.node = part.node;
      cause.by = part.by;
    }
    if (max.first != PartKind::kOwnPreviousRun || part.node != max.second) continue;
    const auto [node, excess] = longest_excess(part, history);
    if (2 * excess >= cause.beyond_usual) {
      cause.kind = CauseKind::kLongRun;
      cause.node = node;
    }
  }
}

}  // namespace ctn::why
