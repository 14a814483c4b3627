#include "record/lineage.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace ctn::record {

ChainTracker::Step* ChainTracker::Stage::find(std::uint64_t number) {
  const std::size_t place = number % kHorizon;
  if (number == 0 || place >= steps.size() || steps[place].number != number) return nullptr;
  return &steps[place];
}

const ChainTracker::Step* ChainTracker::Stage::find(std::uint64_t number) const {
  return const_cast<Stage*>(this)->find(number);
}

ChainTracker::Step& ChainTracker::Stage::put(std::uint64_t number) {
  const std::size_t place = number % kHorizon;
  if (place >= steps.size()) steps.resize(std::min(kHorizon, std::max(place + 1, 2 * steps.size())));
  newest = std::max(newest, number);
  return steps[place] = Step{.number = number};
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
  if (graph.node(path.front()).is_external_clock()) first_.node = path.front();
  if (graph.node(path.back()).is_external_clock()) last_.node = path.back();
}

void ChainTracker::set_clock(NodeId node, const Ticks& ticks) {
  if (node == first_.node) first_.ticks = ticks;
  if (node == last_.node) last_.ticks = ticks;
}

std::vector<ChainSample> ChainTracker::add(const Run& run) {
  if (run.node.index() >= stage_of_.size() || !stage_of_[run.node.index()] || run.number == 0) return {};
  const std::size_t stage = *stage_of_[run.node.index()];
  const Range input = consumed(stage, run);
  Step& step = stages_[stage].put(run.number);
  step.first = input.first;
  step.last = input.last;
  step.begin = stage == 0 && first_.ticks ? first_.ticks->last(run.begin) : run.begin;
  step.end = run.end;
  step.emitted = run.emitted;
  if (stage + 1 < stages_.size() || !run.emitted) return {};

  std::vector<ChainSample> samples;
  if (last_.ticks) {
    wait_for_tick(trace_to_source(step), run.end, samples);
  } else {
    reach_end(trace_to_source(step), run.end, samples);
  }
  return samples;
}

void ChainTracker::wait_for_tick(std::vector<Source> sources, TimePoint end, std::vector<ChainSample>& samples) {
  const TimePoint tick = last_.ticks->next(end);
  // What is known of the clock may have changed a little meanwhile.
  if (!waiting_until_ || tick - *waiting_until_ > last_.ticks->period / 2) {
    if (waiting_until_) reach_end(waiting_, *waiting_until_, samples);
    waiting_.clear();
    waiting_until_ = tick;
  }
  if (first_.ticks) {
    // Another run with the same tick's input brings nothing new.
    const TimePoint newest =
        !waiting_.empty() ? waiting_.back().begin : (previous_ ? previous_->begin : TimePoint::min());
    std::erase_if(sources, [&](const Source& source) { return source.begin <= newest; });
  }
  if (!sources.empty()) waiting_ = std::move(sources);
}

void ChainTracker::reach_end(const std::vector<Source>& sources, TimePoint end, std::vector<ChainSample>& samples) {
  for (const Source& source : sources) {
    if (previous_ && source.number <= previous_->source_run) continue;
    if (previous_ && first_.ticks && source.begin <= previous_->begin) continue;
    samples.push_back(sample(source, end));
    previous_ = samples.back();
  }
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

// The source runs that `output` descends from and no output before it did, the oldest first.
std::vector<ChainTracker::Source> ChainTracker::trace_to_source(const Step& output) {
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
  std::vector<Source> sources;
  for (const Step* step : found) sources.push_back({step->number, step->begin});
  std::sort(sources.begin(), sources.end(), [](const Source& a, const Source& b) { return a.number < b.number; });
  return sources;
}

// Whether a run descends from the source run: its sources are all less, that one is among them, or all that are not
// less are greater. Of several ways by which it does, the path is the one by the newest runs.
std::strong_ordering ChainTracker::trace(std::size_t stage, std::uint64_t number, Trace& of) const {
  of.path[stage] = number;
  if (stage == 0) return number <=> of.source_run;
  const Step* const step = stages_[stage].find(number);
  if (step == nullptr || step->first == 0) return std::strong_ordering::less;
  const Stage& before = stages_[stage - 1];
  const std::uint64_t oldest = before.newest > kHorizon ? before.newest - kHorizon + 1 : 1;
  std::strong_ordering found = std::strong_ordering::less;
  for (std::uint64_t input = std::min(step->last, before.newest); input >= std::max(step->first, oldest); --input) {
    const Step* const ancestor = before.find(input);
    if (of.steps_left == 0) return std::strong_ordering::less;
    --of.steps_left;
    if (ancestor == nullptr || !ancestor->emitted || (stage > 1 && ancestor->first == 0)) continue;
    const std::strong_ordering of_input = trace(stage - 1, input, of);
    if (of_input == std::strong_ordering::equal) return of_input;
    if (of_input == std::strong_ordering::less) return found;  // those before it go back no less far
    found = of_input;
  }
  return found;
}

// The output that brought it is the first that descends from it; those that followed used it again.
std::vector<std::uint64_t> ChainTracker::path_of(std::uint64_t source_run) const {
  Trace searched{.source_run = source_run, .path = std::vector<std::uint64_t>(stages_.size())};
  std::vector<std::uint64_t> found;
  const Stage& end = stages_.back();
  const std::uint64_t oldest = end.newest > kHorizon ? end.newest - kHorizon : 0;
  for (std::uint64_t number = end.newest; number > oldest; --number) {
    const Step* const output = end.find(number);
    if (output == nullptr || !output->emitted) continue;
    const std::strong_ordering traced = trace(stages_.size() - 1, number, searched);
    if (traced == std::strong_ordering::less && !found.empty()) break;
    if (traced == std::strong_ordering::equal) found = searched.path;
  }
  return found;
}

ChainSample ChainTracker::sample(const Source& source, TimePoint end) {
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
