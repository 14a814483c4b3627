#include "trial/samples.h"

#include <algorithm>
#include <cmath>

#include "base/mixed.h"

namespace ctn::trial {
namespace {

// Runs take time, or a schedule could run one over and over without any passing.
constexpr Nanos kShortestRun{1};

Nanos scaled(Nanos cpu, double factor) { return Nanos{std::llround(static_cast<double>(cpu.count()) * factor)}; }

// The kind whose measured runs stand for those on `kind`; kinds.size(): none was measured.
std::size_t measured_kind(const std::vector<std::vector<model::RunTime>>& kinds, std::size_t kind) {
  if (kind < kinds.size() && !kinds[kind].empty()) return kind;
  const auto other = std::find_if(kinds.begin(), kinds.end(), [](const auto& runs) { return !runs.empty(); });
  return static_cast<std::size_t>(other - kinds.begin());
}

double proportion(Millis of, Millis to) { return of > Millis{0} && to > Millis{0} ? of / to : 1.0; }

}  // namespace

Samples::Samples(const graph::App& app, const model::CostTable& costs)
    : kinds_(app.kinds()),
      costs_(model::costs_by_kind(app, costs)),
      draws_(app.graph.nodes().size() * kinds_ * kDraws, kShortestRun),
      waits_(app.graph.nodes().size()) {
  for (const graph::Node& node : app.graph.nodes()) max_threads_.push_back(std::max(node.max_threads, 1));
}

Samples::Samples(const graph::App& app, const model::Workload& work, Nanos since_start, std::uint64_t seed)
    : Samples(app, work.costs(app.graph)) {
  for (std::size_t kind = 0; kind < kinds_; ++kind) {
    const model::Workload there = work.on(app, kind);
    for (std::size_t node = 0; node < max_threads_.size(); ++node) {
      for (std::size_t number = 0; number < kDraws; ++number) {
        const model::RunDraw draw = there.draw(seed, NodeId(node), number + 1, since_start);
        at(node, kind, number) = std::max(draw.cpu, kShortestRun);
        if (kind == 0) set_wait(node, number, draw.wait);
      }
    }
  }
}

Samples::Samples(const graph::App& app, const MeasuredRuns& measured, const model::CostTable& costs)
    : Samples(app, costs) {
  for (std::size_t node = 0; node < max_threads_.size(); ++node) {
    const MeasuredRuns::value_type runs = node < measured.size() ? measured[node] : MeasuredRuns::value_type{};
    const Nanos planned_wait = to_nanos(costs.wait(NodeId(node)));
    for (std::size_t kind = 0; kind < kinds_; ++kind) {
      const Millis planned = costs_[kind][NodeId(node)].single_thread();
      const std::size_t from = measured_kind(runs, kind);
      const bool known = from < runs.size();
      const double factor =
          known && from < kinds_ ? proportion(planned, costs_[from][NodeId(node)].single_thread()) : 1.0;
      for (std::size_t number = 0; number < kDraws; ++number) {
        const model::RunTime run = known ? runs[from][mixed_of(node, number) % runs[from].size()]
                                         : model::RunTime{to_nanos(planned), planned_wait};
        at(node, kind, number) = std::max(scaled(run.cpu, factor), kShortestRun);
        if (kind == 0) set_wait(node, number, run.wait);
      }
    }
  }
}

Samples::Moments Samples::moments(NodeId node, std::size_t kind) const {
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint32_t number = 0; number < kDraws; ++number) {
    const double cost = to_millis(draw(node, kind, number)).count();
    sum += cost;
    squares += cost * cost;
  }
  constexpr auto kCount = static_cast<double>(kDraws);
  const double mean = sum / kCount;
  return {mean, std::max(squares / kCount - mean * mean, 0.0)};
}

Nanos Samples::of_items(NodeId node, std::size_t kind, std::size_t items) const {
  return items == 0 ? Nanos{0} : to_nanos(per_item(node, kind) * static_cast<double>(items));
}

bool Samples::has_batches(NodeId node) const {
  return std::any_of(costs_.begin(), costs_.end(), [&](const auto& costs) { return costs.has_batches(node); });
}

void Samples::set_wait(std::size_t node, std::size_t number, Nanos wait) {
  if (wait == Nanos{0}) return;
  if (waits_[node].empty()) waits_[node].resize(kDraws);
  waits_[node][number] = wait;
}

bool Samples::any_waits() const {
  return std::any_of(waits_.begin(), waits_.end(), [](const std::vector<Nanos>& waits) { return !waits.empty(); });
}

Samples::Waits Samples::mean_wait(NodeId node) const {
  Waits waits;
  if (!this->waits(node)) return waits;
  constexpr auto kCount = static_cast<double>(kDraws);
  for (const Nanos wait : waits_[node.index()]) {
    waits.mean += to_millis(wait).count() / kCount;
    waits.part += wait > Nanos{0} ? 1.0 / kCount : 0.0;
  }
  return waits;
}

Samples::Split Samples::split(NodeId node, std::size_t kind, int threads) const {
  const model::CostProfile& cost = costs_[kind][node];
  const int max = std::clamp(threads, 1, max_threads_[node.index()]);
  const double part = proportion(cost.with_threads(max, max_threads_[node.index()]), cost.with_threads(1, 1));
  return {cost.threads_used(max), part};
}

}  // namespace ctn::trial
