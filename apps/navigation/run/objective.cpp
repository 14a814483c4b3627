#include "run/objective.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>

namespace ctn::navigation::run {
namespace {

using std::chrono::nanoseconds;

const ChainSnapshot* chain_of(const Snapshot& snapshot, const TermSnapshot& term) {
  const auto found = std::ranges::find_if(snapshot.chains, [&](const ChainSnapshot& chain) {
    return fmt::format("{}", fmt::join(chain.path, " -> ")) == term.term;
  });
  return found == snapshot.chains.end() ? nullptr : &*found;
}

const NodeSnapshot* node_of(const Snapshot& snapshot, const TermSnapshot& term) {
  const auto found = std::ranges::find_if(
      snapshot.nodes, [&](const NodeSnapshot& node) { return "period of " + node.name == term.term; });
  return found == snapshot.nodes.end() ? nullptr : &*found;
}

template <class Measured>
std::optional<double> sum_of(const Snapshot& snapshot, Measured measured) {
  double sum = 0.0;
  for (const TermSnapshot& term : snapshot.objective) {
    const std::optional<double> value = measured(term);
    if (!value) return std::nullopt;
    sum += term.weight * *value;
  }
  return snapshot.objective.empty() ? std::nullopt : std::optional(sum);
}

// Of the responses that came in between.
std::optional<double> mean_between(const Summary& before, const Summary& after) {
  if (after.count <= before.count) return std::nullopt;
  const auto total = [](const Summary& summary) { return summary.mean * static_cast<double>(summary.count); };
  return (total(after) - total(before)) / static_cast<double>(after.count - before.count);
}

std::optional<double> objective_between(const Snapshot& before, const Snapshot& after, nanoseconds time) {
  return sum_of(after, [&](const TermSnapshot& term) -> std::optional<double> {
    const ChainSnapshot* const chain = chain_of(after, term);
    const ChainSnapshot* const chain_before = chain_of(before, term);
    if (chain != nullptr && chain_before != nullptr) {
      return mean_between(chain_before->response_ms, chain->response_ms);
    }
    const NodeSnapshot* const node = node_of(after, term);
    const NodeSnapshot* const node_before = node_of(before, term);
    if (node == nullptr || node_before == nullptr || node->compute_ms.count <= node_before->compute_ms.count) {
      return std::nullopt;
    }
    const double ms = std::chrono::duration<double, std::milli>(time).count();
    return ms / static_cast<double>(node->compute_ms.count - node_before->compute_ms.count);
  });
}

}  // namespace

std::optional<double> objective_of(const Snapshot& snapshot) {
  return sum_of(snapshot, [&](const TermSnapshot& term) -> std::optional<double> {
    if (const ChainSnapshot* const chain = chain_of(snapshot, term)) {
      return chain->response_ms.count > 0 ? std::optional(chain->response_ms.mean) : std::nullopt;
    }
    const NodeSnapshot* const node = node_of(snapshot, term);
    return node != nullptr && node->rate_hz > 0.0 ? std::optional(1e3 / node->rate_hz) : std::nullopt;
  });
}

void ObjectiveByTime::add(nanoseconds now, Snapshot snapshot) {
  values_.push_back(last_.warmed_up ? objective_between(last_, snapshot, now - last_at_) : std::nullopt);
  last_ = std::move(snapshot);
  last_at_ = now;
  end_ += kObjectiveBucket;
}

}  // namespace ctn::navigation::run
