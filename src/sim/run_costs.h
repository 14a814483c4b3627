// What each run costs, as the simulation asks for it run by run.
//
// Units: in the types. Thread safety: none; one owner. The same questions in the same order get the same answers.
#pragma once

#include <cstddef>
#include <cstdint>
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
};

// Drawn from a cost file's distributions: what `catan run --synthetic` with the same seed burns. On a machine that is
// `slowdown` times as slow (> 0), each run costs so many times as much.
class DrawnCosts : public RunCosts {
 public:
  DrawnCosts(const graph::App& app, const model::Workload& work, std::uint64_t seed, double slowdown = 1.0)
      : seed_(seed) {
    for (std::size_t kind = 0; kind < app.kinds(); ++kind) {
      model::Workload& there = by_kind_.emplace_back(work.on(app, kind));
      if (slowdown == 1.0) continue;
      for (std::size_t node = 0; node < app.graph.nodes().size(); ++node) {
        there.set(NodeId(node), there[NodeId(node)].times(slowdown));
      }
    }
  }

  int threads_used(NodeId node, int max) const override { return by_kind_.front()[node].cost.threads_used(max); }
  model::RunDraw draw(NodeId node, std::uint64_t number, Nanos since_start, int threads, std::size_t kind) override {
    return by_kind_[kind].draw(seed_, node, number, since_start, threads);
  }

 private:
  std::vector<model::Workload> by_kind_;
  std::uint64_t seed_;
};

}  // namespace ctn::sim
