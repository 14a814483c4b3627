#include "record/lineage.h"

#include <algorithm>
#include <cassert>

namespace ctn::record {

ChainTracker::Step* ChainTracker::Stage::find(std::uint64_t number) {
  const std::size_t slot = number % kHorizon;
  if (number == 0 || slot >= steps.size() || steps[slot].number != number) return nullptr;
  return &steps[slot];
}

ChainTracker::Step& ChainTracker::Stage::put(std::uint64_t number) {
  const std::size_t slot = number % kHorizon;
  if (slot >= steps.size()) steps.resize(std::min(kHorizon, std::max(slot + 1, 2 * steps.size())));
  newest = std::max(newest, number);
  return steps[slot] = Step{.number = number};
}

ChainTracker::ChainTracker(const graph::Graph& graph, std::span<const NodeId> path) : stage_of_(graph.nodes().size()) {
  bool passed_external = false;
  for (const NodeId id : path) {
    const graph::Node& node = graph.node(id);
    if (node.external) {
      passed_external = !stages_.empty();
      continue;
    }
    stage_of_[id.index()] = stages_.size();
    stages_.push_back(
        {.node = id, .behind_external = passed_external, .queue = node.input == graph::InputKind::kQueue, .steps = {}});
    passed_external = false;
  }
  assert(!stages_.empty());
}

std::vector<ChainSample> ChainTracker::add(const Run& run) {
  if (run.node.index() >= stage_of_.size() || !stage_of_[run.node.index()] || run.number == 0) return {};
  const std::size_t stage = *stage_of_[run.node.index()];
  const Range input = consumed(stage, run);
  Step& step = stages_[stage].put(run.number);
  step.first = input.first;
  step.last = input.last;
  step.begin = run.begin;
  step.end = run.end;
  step.emitted = run.emitted;
  if (stage + 1 < stages_.size() || !run.emitted) return {};

  std::vector<const Step*> sources = trace_to_source(step);
  std::sort(sources.begin(), sources.end(), [](const Step* a, const Step* b) { return a->number < b->number; });
  std::vector<ChainSample> samples;
  for (const Step* source : sources) {
    if (previous_ && source->number <= previous_->source_run) continue;
    samples.push_back(sample(*source, run.end));
    previous_ = samples.back();
  }
  return samples;
}

ChainTracker::Range ChainTracker::consumed(std::size_t stage, const Run& run) {
  if (stage == 0) return {};
  if (stages_[stage].behind_external) return inferred(stage, run);
  const NodeId predecessor = stages_[stage - 1].node;
  const auto entry = std::find_if(run.consumed.begin(), run.consumed.end(),
                                  [&](const Consumed& input) { return input.predecessor == predecessor; });
  if (entry == run.consumed.end() || entry->first == 0) return {};
  return {entry->first, entry->last};
}

ChainTracker::Range ChainTracker::inferred(std::size_t stage, const Run& run) {
  Stage& before = stages_[stage - 1];
  const std::uint64_t oldest = before.newest > kHorizon ? before.newest - kHorizon : 0;
  for (std::uint64_t number = before.newest; number > oldest; --number) {
    const Step* step = before.find(number);
    if (step == nullptr || !step->emitted || step->end > run.begin) continue;
    const std::uint64_t since = std::exchange(stages_[stage].taken, number);
    if (!stages_[stage].queue) return {number, number};
    return since < number ? Range{since + 1, number} : Range{};
  }
  return {};
}

// The source runs that `output` descends from and no output before it did, in no order.
std::vector<const ChainTracker::Step*> ChainTracker::trace_to_source(const Step& output) {
  std::vector<const Step*> found{&output};
  for (std::size_t stage = stages_.size() - 1; stage > 0 && !found.empty(); --stage) {
    Stage& before = stages_[stage - 1];
    const std::uint64_t oldest = before.newest > kHorizon ? before.newest - kHorizon + 1 : 1;
    std::vector<const Step*> ancestors;
    for (const Step* step : found) {
      const std::uint64_t last = std::min(step->last, before.newest);
      for (std::uint64_t number = std::max(step->first, oldest); number <= last; ++number) {
        Step* ancestor = before.find(number);
        if (ancestor == nullptr || !ancestor->emitted || ancestor->traced) continue;
        ancestor->traced = true;
        ancestors.push_back(ancestor);
      }
    }
    found = std::move(ancestors);
  }
  return found;
}

ChainSample ChainTracker::sample(const Step& source, TimePoint end) {
  ChainSample sample{.source_run = source.number,
                     .begin = source.begin,
                     .end = end,
                     .latency = end - source.begin,
                     .period = std::nullopt,
                     .response = std::nullopt};
  if (previous_) {
    sample.period = end - previous_->end;
    sample.response = end - previous_->begin;
  }
  return sample;
}

}  // namespace ctn::record
