#include "policy/node_costs.h"

#include <algorithm>
#include <string>

namespace ctn::policy {
namespace {

// A node's first runs find its code and data in no cache and its pages unmapped. Once there are others they say nothing
// of what it costs, and in a window of 50 they would decide its 95th percentile.
constexpr std::uint64_t kColdRuns = 3;

}  // namespace

NodeCosts::NodeCosts(const graph::App& app, NodeId node) : app_(app), node_(node) {
  kinds_.assign(app.kinds(), nothing_seen());
}

NodeCosts::OnKind NodeCosts::nothing_seen() const {
  const std::vector<std::string>& modes = app_.graph.node(node_).modes;
  return {model::Estimator(app_.scheduler.window, app_.scheduler.percentile, modes),
          std::vector<model::ChangeDetector>(std::max<std::size_t>(modes.size(), 1))};
}

std::optional<record::CostChange> NodeCosts::add(const record::Run& run, std::size_t kind) {
  if (run.number == kColdRuns + 1) kinds_.assign(kinds_.size(), nothing_seen());
  OnKind& seen = kinds_[kind];
  newest_kind_ = kind;
  const std::size_t mode = run.mode < seen.detectors.size() ? run.mode : 0;
  seen.estimator.add({run.cpu, run.wait}, mode);
  const std::optional<std::size_t> runs = seen.detectors[mode].add(run.cpu);
  return runs ? changed(run, kind, mode, *runs) : std::nullopt;
}

std::optional<record::CostChange> NodeCosts::changed(const record::Run& run, std::size_t kind, std::size_t mode,
                                                     std::size_t runs) {
  const std::optional<model::Estimator::Shift> shift = kinds_[kind].estimator.forget_before(mode, runs);
  if (!shift) return std::nullopt;  // a window so short has followed by itself
  for (std::size_t other = 0; other < kinds_.size(); ++other) {
    if (other == kind || shift->before.count() <= 0.0 || shift->after.count() <= 0.0) continue;
    kinds_[other].estimator.rescale(shift->after / shift->before, mode);
    kinds_[other].detectors[mode].rescale(shift->after / shift->before);
  }
  return record::CostChange{.at = run.end,
                            .node = node_,
                            .mode = static_cast<std::uint32_t>(mode),
                            .core_kind = static_cast<int>(kind),
                            .before = to_nanos(shift->before),
                            .after = to_nanos(shift->after),
                            .runs = runs};
}

void NodeCosts::put_into(model::CostTable& table, double percentile) const {
  if (!measured()) return;
  table.set_wait(node_, kinds_[newest_kind_].estimator.wait(percentile));
  const model::CostProfile newest = kinds_[newest_kind_].estimator.profile(percentile);
  if (app_.core_kinds.empty()) return table.set(node_, newest);
  table.set(node_, newest.times(app_.core_kinds[newest_kind_].speed));
  for (std::size_t kind = 0; kind < kinds_.size(); ++kind) {
    const model::Estimator& estimator = kinds_[kind].estimator;
    if (estimator.count() > 0) table.set_on(node_, kind, estimator.profile(percentile));
  }
}

std::vector<std::vector<model::RunTime>> NodeCosts::runs() const {
  std::vector<std::vector<model::RunTime>> runs;
  for (const OnKind& kind : kinds_) runs.push_back(kind.estimator.sample());
  return runs;
}

void NodeCosts::rescale(std::size_t kind, double factor) {
  kinds_[kind].estimator.rescale(factor);
  for (model::ChangeDetector& detector : kinds_[kind].detectors) detector.rescale(factor);
}

void NodeCosts::invalidate(std::size_t kind) {
  kinds_[kind].estimator.invalidate();
  for (model::ChangeDetector& detector : kinds_[kind].detectors) detector = {};
}

}  // namespace ctn::policy
