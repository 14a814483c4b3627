#include "report/predictions.h"

#include <fmt/format.h>

#include <algorithm>

#include "plan/json.h"
#include "plan/plan.h"

namespace ctn::report {
namespace {

class Mean {
 public:
  void add(double value, double weight) {
    sum_ += weight * value;
    weight_ += weight;
  }
  std::optional<double> value() const { return weight_ > 0.0 ? std::optional(sum_ / weight_) : std::nullopt; }

 private:
  double sum_ = 0.0;
  double weight_ = 0.0;
};

struct ChainMeans {
  std::vector<NodeId> path;
  Mean response;
  Mean latency;
  Mean period;
  Mean promised;
};

class Averager {
 public:
  explicit Averager(const graph::App& app) : app_(app), rates_(app.graph.nodes().size()) {
    for (const graph::Term& term : app.objective) {
      if (term.metric == graph::Metric::kResponseTime) chains_.push_back({term.path, {}, {}, {}, {}});
    }
  }

  void add(const plan::Plan& plan, double seconds) {
    // What is expected, where the plan says so, else what is planned: figures for means, to stand beside means.
    objective_.add(plan.expected ? plan.expected->objective : plan.objective, seconds);
    for (std::size_t i = 0; i < std::min(chains_.size(), plan.chains.size()); ++i) {
      const plan::ChainPlan& chain = plan.chains[i];
      if (chain.path != chains_[i].path) continue;
      const plan::Expectation::Chain shown =
          plan.expected ? plan.expected->chains[i]
                        : plan::Expectation::Chain{chain.response, chain.latency, chain.period};
      chains_[i].response.add(shown.response.count(), seconds);
      chains_[i].latency.add(shown.latency.count(), seconds);
      chains_[i].period.add(shown.period.count(), seconds);
      chains_[i].promised.add(chain.response.count(), seconds);
    }
    for (std::size_t i = 0; i < rates_.size(); ++i) {
      const auto subchain = app_.graph.nodes()[i].subchain;
      if (!subchain || subchain->index() >= plan.subchains.size()) continue;
      const Millis period =
          plan.expected ? plan.expected->subchains[subchain->index()].period : plan.subchains[subchain->index()].period;
      if (period > Millis{0}) rates_[i].add(1000.0 / period.count(), seconds);
    }
  }

  void give(Predictions& result) const {
    result.objective = objective_.value();
    for (const ChainMeans& chain : chains_) {
      const auto response = chain.response.value();
      result.chains.push_back(response ? std::optional(ChainPrediction{*response, *chain.latency.value(),
                                                                       *chain.period.value(), *chain.promised.value()})
                                       : std::nullopt);
    }
    for (const Mean& rate : rates_) result.rate_hz.push_back(rate.value());
  }

 private:
  const graph::App& app_;
  Mean objective_;
  std::vector<ChainMeans> chains_;
  std::vector<Mean> rates_;  // by NodeId
};

}  // namespace

Result<Predictions> predictions(const record::Reader& record, TimePoint begin, TimePoint end) {
  const auto changes = record.plans();
  if (!changes) return changes.error();
  Averager averager(record.app());
  Predictions result;
  for (std::size_t i = 0; i < changes->size(); ++i) {
    const record::PlanChange& change = changes->at(i);
    const TimePoint from = std::max(begin, change.at);
    const TimePoint to = i + 1 < changes->size() ? std::min(end, changes->at(i + 1).at) : end;
    if (to <= from) continue;
    const auto plan = plan::from_json(change.json, record.app(), fmt::format("plan {} of the record", i + 1));
    if (!plan) return plan.error();
    averager.add(*plan, std::chrono::duration<double>(to - from).count());
    ++result.plans;
    result.relax_factor = std::max(result.relax_factor, plan->relax_factor);
  }
  averager.give(result);
  return result;
}

}  // namespace ctn::report
