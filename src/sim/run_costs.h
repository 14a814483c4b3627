// What each run costs, as the simulation asks for it run by run. A run whose function says itself what its work was
// worth (Run::charge()) costs that, in place of what was drawn for it.
//
// Units: in the types. Thread safety: none; one owner. The same questions in the same order get the same answers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "graph/app.h"
#include "model/workload.h"

namespace ctn::sim {

class RunCosts {
 public:
  virtual ~RunCosts() = default;

  // On how many of at most `max` threads (>= 1) a run of the node works.
  virtual int threads_used(NodeId node, int max) const = 0;
  // Run `number` (from 1) of the node, begun `since_start` after the start on a core of that kind, on `threads`
  // threads. Each run is asked for once, when it begins.
  virtual model::RunDraw draw(NodeId node, std::uint64_t number, Nanos since_start, int threads, std::size_t kind) = 0;

  // Whether draw() says what the node's runs cost; else these must charge it themselves.
  virtual bool knows(NodeId /*node*/) const { return true; }
  // What each of its `threads` threads burns in a run that was charged so much (>= 0), begun on a core of that kind.
  virtual Nanos share_of_charge(NodeId /*node*/, Nanos charged, int threads, std::size_t /*kind*/) const {
    return charged / threads;
  }
};

// Drawn from a cost file's distributions: what `catan run --synthetic` with the same seed burns. On a slower machine
// each run costs `slowdowns` times as much (by NodeId, > 0; empty: 1), also where it was charged. `given`: by NodeId,
// for which nodes the file says anything; empty: for all. An unscheduled node that it leaves out costs nothing.
class DrawnCosts : public RunCosts {
 public:
  DrawnCosts(const graph::App& app, const model::Workload& work, std::uint64_t seed, std::vector<double> slowdowns = {},
             const std::vector<bool>& given = {})
      : seed_(seed), slowdowns_(std::move(slowdowns)), known_(app.graph.nodes().size(), true) {
    slowdowns_.resize(known_.size(), 1.0);
    for (std::size_t node = 0; node < given.size(); ++node) {
      known_[node] = given[node] || app.graph.nodes()[node].unscheduled;
    }
    for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
      model::Workload& there = by_kind_.emplace_back(work.on(app, kind));
      speeds_.push_back(app.core_kinds.empty() ? 1.0 : app.core_kinds[kind].speed);
      for (std::size_t node = 0; node < known_.size(); ++node) {
        if (slowdowns_[node] != 1.0) there.set(NodeId(node), there[NodeId(node)].times(slowdowns_[node]));
      }
    }
  }

  int threads_used(NodeId node, int max) const override { return by_kind_.front()[node].cost.threads_used(max); }
  model::RunDraw draw(NodeId node, std::uint64_t number, Nanos since_start, int threads, std::size_t kind) override {
    return by_kind_[kind].draw(seed_, node, number, since_start, threads);
  }
  bool knows(NodeId node) const override { return known_[node.index()]; }
  Nanos share_of_charge(NodeId node, Nanos charged, int threads, std::size_t kind) const override {
    const double factor = slowdowns_[node.index()] / speeds_[kind];
    return to_nanos(std::min(to_millis(charged) * factor / threads, model::kLongestRun));
  }

 private:
  std::vector<model::Workload> by_kind_;
  std::vector<double> speeds_;  // by kind
  std::uint64_t seed_;
  std::vector<double> slowdowns_;  // by NodeId, as the next
  std::vector<bool> known_;
};

}  // namespace ctn::sim
