#include "model/workload.h"

#include <algorithm>
#include <cassert>

#include "base/mixed.h"
#include "model/portable_math.h"

namespace ctn::model {
namespace {

constexpr double kZ95 = 1.6448536269514722;  // 95 % of a standard normal variable are below it

// The random numbers of one run: the same for the same seed, node and run, so no state is carried from run to run.
class RandomDraws {
 public:
  enum class Purpose : std::uint64_t { kMode = 1, kTime = 2, kSpike = 3, kWait = 4 };

  RandomDraws(std::uint64_t seed, NodeId node, std::uint64_t run) : state_(mixed_of(seed, node.index(), run)) {}

  // Uniform in (0, 1), both ends excluded.
  double uniform(Purpose purpose) const {
    const std::uint64_t bits = mixed(state_ + kGolden * static_cast<std::uint64_t>(purpose)) >> 12U;
    return (static_cast<double>(bits) + 0.5) * 0x1p-52;
  }

 private:
  std::uint64_t state_;
};

std::size_t drawn_mode(const std::vector<ModeCost>& modes, double uniform) {
  std::size_t likely = 0;  // rounding may leave a sum just below 1: then the last mode that happens at all
  double sum = 0.0;
  for (std::size_t mode = 0; mode < modes.size(); ++mode) {
    if (modes[mode].probability <= 0.0) continue;
    likely = mode;
    sum += modes[mode].probability;
    if (uniform < sum) break;
  }
  return likely;
}

// By how much a run differs from the cost; log-normal. `uniform`: a random number in (0, 1).
double drawn_factor(Millis cost, std::optional<Millis> typical, double uniform) {
  if (!typical || *typical >= cost) return 1.0;
  const double spread = portable_log(cost / *typical);
  const double exponent = spread * (inverse_normal(uniform) / kZ95 - 1.0);
  return portable_exp(std::clamp(exponent, -700.0, 700.0));
}

}  // namespace

NodeWork NodeWork::times(double factor) const {
  NodeWork scaled = *this;
  scaled.cost = cost.times(factor);
  for (auto& median : scaled.typical) {
    if (median) *median *= factor;
  }
  scaled.spikes.extra *= factor;
  return scaled;
}

Nanos RunDraw::cpu_with(std::size_t items) const {
  if (per_item == Nanos{0} || items == 0) return cpu;
  const Millis batch = to_millis(per_item) * static_cast<double>(items);
  return to_nanos(std::min(to_millis(cpu) + batch, kLongestRun));
}

Workload::Workload(const graph::Graph& graph) : nodes_(graph.nodes().size()), waits_(graph.nodes().size()) {
  for (const graph::Node& node : graph.nodes()) max_threads_.push_back(node.max_threads);
}

Workload Workload::on(const graph::App& app, std::size_t kind) const {
  assert(kind < app.kinds());
  Workload work = *this;
  work.on_kind_.clear();
  if (app.core_kinds.empty()) return work;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto given = on_kind_.find({NodeId(i), kind});
    work.nodes_[i] = given != on_kind_.end() ? given->second : nodes_[i].times(1.0 / app.core_kinds[kind].speed);
  }
  return work;
}

CostTable Workload::costs(const graph::Graph& graph) const {
  CostTable table(graph, Millis{0});
  for (std::size_t i = 0; i < nodes_.size(); ++i) table.set(NodeId(i), nodes_[i].cost);
  for (const auto& [key, work] : on_kind_) table.set_on(key.first, key.second, work.cost);
  for (std::size_t i = 0; i < waits_.size(); ++i) table.set_wait(NodeId(i), waits_[i].wait);
  return table;
}

RunDraw Workload::draw(std::uint64_t seed, NodeId node, std::uint64_t number, Nanos since_start, int threads) const {
  assert(threads >= 1);
  const NodeWork& work = nodes_[node.index()];
  const RandomDraws draws(seed, node, number);
  const std::size_t mode = drawn_mode(work.cost.modes(), draws.uniform(RandomDraws::Purpose::kMode));
  const Millis alone = work.cost.modes()[mode].cost;
  const int max = max_threads_[node.index()];
  const int used = std::min(threads, max);
  const auto on_threads = [&](const CostProfile& cost) {
    return cost.by_threads().empty() ? cost.modes()[mode].cost / used : cost.with_threads(used, max);
  };
  const Millis shared = on_threads(work.cost);
  const std::optional<Millis> typical = mode < work.typical.size() ? work.typical[mode] : std::nullopt;

  Millis cpu = shared * drawn_factor(alone, typical, draws.uniform(RandomDraws::Purpose::kTime));
  const double grown = 1.0 + work.growth * std::max(0.0, in_seconds(since_start));
  cpu *= grown;
  if (draws.uniform(RandomDraws::Purpose::kSpike) < work.spikes.probability) cpu += work.spikes.extra;

  Millis wait = waits_[node.index()].wait;
  if (waits_[node.index()].typical) {
    wait *= drawn_factor(wait, waits_[node.index()].typical, draws.uniform(RandomDraws::Purpose::kWait));
  }
  Millis per_item{0};
  if (work.cost.per_item() > Millis{0}) per_item = (on_threads(work.cost.with_items(1.0)) - shared) * grown;
  const auto drawn = [](Millis time) { return to_nanos(std::min(time, kLongestRun)); };
  return {mode, drawn(cpu), drawn(wait), drawn(per_item)};
}

}  // namespace ctn::model
