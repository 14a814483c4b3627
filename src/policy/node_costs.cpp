#include "policy/node_costs.h"

#include <algorithm>
#include <cmath>

namespace ctn::policy {
namespace {

// A node's first runs find its code and data in no cache and its pages unmapped. Once there are others they say nothing
// of what it costs, and in a window of 50 they would decide its 95th percentile.
constexpr std::uint64_t kColdRuns = 3;
// So are the first on another number of threads: they are left out, and nothing is told of it before there are a few.
constexpr std::size_t kMinElapsedRuns = 5;
// More than a record has of a node.
constexpr int kAllRuns = 100'000'000;
// What an item adds has changed by little, if by no more than this part of it.
constexpr double kMoved = 0.1;

// What stands for runs on one thread: those on the fewest. Precondition: there are any.
const model::Estimator& alone(const auto& by_threads) { return by_threads.begin()->second.cpu; }

}  // namespace

NodeCosts::NodeCosts(const graph::App& app, NodeId node, RunsThatCount count)
    : app_(app),
      node_(node),
      counted_(count),
      takes_batches_(app.graph.node(node).input == graph::InputKind::kQueue),
      kinds_(app.kinds()) {}

NodeCosts::Seen& NodeCosts::like(std::size_t kind, int threads) {
  const auto known = kinds_[kind].find(threads);
  if (known != kinds_[kind].end()) return known->second;
  const std::vector<std::string>& modes = app_.graph.node(node_).modes;
  const int window = counted_ == RunsThatCount::kAll ? kAllRuns : app_.scheduler.window;
  const model::Estimator nothing(window, app_.scheduler.percentile, modes);
  const std::vector<model::ChangeDetector> detectors(std::max<std::size_t>(modes.size(), 1));
  return kinds_[kind].emplace(threads, Seen{nothing, nothing, detectors}).first->second;
}

void NodeCosts::take_per_item(Seen& seen, int threads) {
  seen.cpu.set_per_item(seen.batches.per_item());
  seen.elapsed.set_per_item(seen.batches.per_item() / threads);
}

// What an item adds has changed: unless it is by little, runs are compared from now on with those that come.
void NodeCosts::per_item_changed(Seen& seen, int threads, Millis before) {
  take_per_item(seen, threads);
  const Millis per_item = seen.batches.per_item();
  if (std::abs((per_item - before).count()) <= kMoved * per_item.count()) return;
  for (model::ChangeDetector& detector : seen.detectors) detector = {};
}

std::optional<record::CostChange> NodeCosts::add(const record::Run& run, std::size_t items, std::size_t kind) {
  if (run.number == kColdRuns + 1) forget();
  newest_kind_ = kind;
  newest_threads_ = run.threads;
  Seen& alike = like(kind, run.threads);
  const std::size_t mode = run.mode < alike.detectors.size() ? run.mode : 0;
  alike.cpu.add({run.cpu, run.wait}, mode, items);
  if (run.threads > 1 && ++alike.runs > kColdRuns) alike.elapsed.add({run.elapsed, run.wait}, mode, items);
  const Millis per_item = alike.batches.per_item();
  if (takes_batches_ && alike.batches.add(run.cpu, items, mode)) per_item_changed(alike, run.threads, per_item);
  if (counted_ == RunsThatCount::kAll) return std::nullopt;
  const std::optional<std::size_t> runs = alike.detectors[mode].add(alike.batches.without_items(run.cpu, items));
  if (!runs) return std::nullopt;
  if (takes_batches_ && alike.batches.explains(mode, *runs)) {
    per_item_changed(alike, run.threads, per_item);
    return std::nullopt;
  }
  return changed(run, kind, mode, *runs);
}

std::optional<record::CostChange> NodeCosts::changed(const record::Run& run, std::size_t kind, std::size_t mode,
                                                     std::size_t runs) {
  Seen& alike = like(kind, run.threads);
  const std::optional<model::Estimator::Shift> shift = alike.cpu.forget_before(mode, runs);
  if (run.threads > 1) alike.elapsed.forget_before(mode, runs);
  if (takes_batches_) alike.batches.forget_before(mode, runs);
  if (!shift) return std::nullopt;  // a window so short has followed by itself
  const bool known = shift->before.count() > 0.0 && shift->after.count() > 0.0;
  for (OnKind& by_threads : kinds_) {
    for (auto& [threads, other] : by_threads) {
      if (&other == &alike || !known) continue;
      other.cpu.rescale(shift->after / shift->before, mode);
      other.elapsed.rescale(shift->after / shift->before, mode);
      other.batches.rescale(shift->after / shift->before);
      take_per_item(other, threads);
      other.detectors[mode].rescale(shift->after / shift->before);
    }
  }
  return record::CostChange{.at = run.end,
                            .node = node_,
                            .mode = static_cast<std::uint32_t>(mode),
                            .core_kind = static_cast<int>(kind),
                            .before = to_nanos(shift->before),
                            .after = to_nanos(shift->after),
                            .runs = runs};
}

std::size_t NodeCosts::count() const {
  std::size_t count = 0;
  for (const auto& [threads, seen] : kinds_[newest_kind_]) count += seen.cpu.count();
  return count;
}

void NodeCosts::put_into(model::CostTable& table, double percentile) const {
  if (!measured()) return;
  table.set_wait(node_, kinds_[newest_kind_].at(newest_threads_).cpu.wait(percentile));
  for (std::size_t kind = 0; kind < kinds_.size(); ++kind) {
    if (kinds_[kind].empty()) continue;
    const model::CostProfile on_one = alone(kinds_[kind]).profile(percentile);
    const model::CostProfile profile = on_one.with_measured(elapsed_on(kind, on_one.single_thread(), percentile));
    if (!app_.core_kinds.empty()) table.set_on(node_, kind, profile);
    if (kind != newest_kind_) continue;
    table.set(node_, app_.core_kinds.empty() ? profile : profile.times(app_.core_kinds[kind].speed));
  }
}

// On each number of threads that it ran on anywhere; `alone_here`: on one thread, on that kind.
std::map<int, Millis> NodeCosts::elapsed_on(std::size_t kind, Millis alone_here, double percentile) const {
  std::map<int, Millis> elapsed;
  const auto add_those_on = [&](const OnKind& by_threads) {
    if (by_threads.empty()) return;
    const Millis there = alone(by_threads).profile(percentile).single_thread();
    if (there <= Millis{0}) return;
    for (const auto& [threads, seen] : by_threads) {
      if (threads == 1 || seen.elapsed.count() < kMinElapsedRuns) continue;
      elapsed.try_emplace(threads, seen.elapsed.profile(percentile).single_thread() * (alone_here / there));
    }
  };
  add_those_on(kinds_[kind]);
  for (const OnKind& other : kinds_) add_those_on(other);
  return elapsed;
}

std::vector<std::vector<model::RunTime>> NodeCosts::runs() const {
  std::vector<std::vector<model::RunTime>> runs;
  for (const OnKind& by_threads : kinds_) {
    runs.push_back(by_threads.empty() ? std::vector<model::RunTime>() : alone(by_threads).sample());
  }
  return runs;
}

void NodeCosts::rescale(std::size_t kind, double factor) {
  for (auto& [threads, seen] : kinds_[kind]) {
    seen.cpu.rescale(factor);
    seen.elapsed.rescale(factor);
    seen.batches.rescale(factor);
    take_per_item(seen, threads);
    for (model::ChangeDetector& detector : seen.detectors) detector.rescale(factor);
  }
}

void NodeCosts::invalidate(std::size_t kind) {
  for (auto& [threads, seen] : kinds_[kind]) {
    seen.cpu.invalidate();
    seen.elapsed.invalidate();
    seen.batches.invalidate();
    for (model::ChangeDetector& detector : seen.detectors) detector = {};
  }
}

}  // namespace ctn::policy
