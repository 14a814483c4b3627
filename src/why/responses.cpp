#include "why/responses.h"

#include <algorithm>
#include <span>
#include <utility>

#include "base/statistics.h"
#include "why/causes.h"

namespace ctn::why {
namespace {

// From about how many responses causes_of() finds out what is usual, so that it does not take long.
constexpr std::size_t kEnoughToTell = 256;

Chain stages_of(const graph::App& app, std::size_t term) {
  Chain chain;
  for (const NodeId node : app.objective[term].path) {
    if (!app.graph.node(node).external) chain.nodes.push_back(node);
  }
  chain.taken.resize(chain.nodes.size());
  return chain;
}

}  // namespace

Responses::Responses(const graph::App& app, std::size_t term)
    : app_(app), term_(term), chain_(stages_of(app, term)), tracker_(app.graph, app.objective[term].path) {}

std::optional<std::size_t> Responses::stage_of(NodeId node) const {
  const auto found = std::find(chain_.nodes.begin(), chain_.nodes.end(), node);
  if (found == chain_.nodes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - chain_.nodes.begin());
}

void Responses::add(const record::Run& run) {
  const std::optional<std::size_t> stage = stage_of(run.node);
  if (!stage) return;
  std::uint64_t taken = 0;
  for (const record::Consumed& input : run.consumed) {
    if (*stage > 0 && input.predecessor == chain_.nodes[*stage - 1]) taken = input.last;
  }
  chain_.taken[*stage].push_back(taken);
  for (const record::ChainSample& sample : tracker_.add(run)) {
    std::vector<std::uint64_t> path = tracker_.path_of(sample.source_run);
    path.resize(chain_.nodes.size());  // one that is not known gets runs of number 0
    samples_.push_back(sample);
    paths_.insert(paths_.end(), path.begin(), path.end());
  }
}

void Responses::add(const record::ClockReading& reading) {
  tracker_.set_clock(reading.node, reading.ticks);
  const NodeId first = app_.objective[term_].path.front();
  if (reading.node == first && app_.graph.node(first).external) chain_.begins_at_clock = true;
}

void Responses::expect_clock(const Survey& survey) {
  const NodeId first = app_.objective[term_].path.front();
  chain_.begins_at_clock = app_.graph.node(first).external && survey.knows_clock(first);
}

// Of each stage, the first run that the sample reached. The one that the next stage consumed may be a later one, which
// used the sample again while it waited there.
Way Responses::way(const History& history, std::size_t sample) const {
  Way way{samples_[sample], {}};
  for (std::size_t stage = 0; stage < chain_.nodes.size(); ++stage) {
    const std::optional<RunRef> run = history.find(chain_.nodes[stage], paths_[sample * chain_.nodes.size() + stage]);
    if (!run) return {samples_[sample], {}};
    way.runs.push_back(run->index);
  }
  for (std::size_t stage = 1; stage + 1 < chain_.nodes.size(); ++stage) {
    const std::span<const RunTimes> runs = history.runs(chain_.nodes[stage]);
    const std::uint64_t taken = history.run({chain_.nodes[stage - 1], way.runs[stage - 1]}).number;
    for (std::size_t index = way.runs[stage]; index > 0 && chain_.taken[stage][index - 1] >= taken; --index) {
      if (runs[index - 1].emitted) way.runs[stage] = index - 1;
    }
  }
  return way;
}

Response Responses::response(const History& history, std::size_t end) const {
  Response response{.begin = samples_[end - 1].begin, .end = samples_[end].end, .source_run = samples_[end].source_run};
  const Way way_before = way(history, end - 1);
  const Way way_here = way(history, end);
  if (way_before.runs.empty() || way_here.runs.empty()) {
    response.parts = {{PartKind::kUnexplained, response.begin, response.end, chain_.nodes.front()}};
  } else {
    response.parts = Walk(history, chain_).take_apart(way_before, way_here);
  }
  return response;
}

std::optional<std::size_t> Responses::find(const Span& response) const {
  auto found = std::partition_point(samples_.begin(), samples_.end(),
                                    [&](const record::ChainSample& sample) { return sample.end < response.end; });
  for (; found != samples_.end() && found->end == response.end; ++found) {
    if (found == samples_.begin() || !found->response) continue;
    if ((found - 1)->begin == response.begin) return static_cast<std::size_t>(found - samples_.begin());
  }
  return std::nullopt;
}

std::vector<CauseKind> Responses::causes_of(const History& history, std::span<const Span> late) const {
  std::vector<std::size_t> ends;
  std::vector<Nanos> lengths;
  for (std::size_t end = 1; end < samples_.size(); ++end) {
    if (!samples_[end].response || length(end) <= Nanos{0}) continue;
    ends.push_back(end);
    lengths.push_back(length(end));
  }
  Causes causes;
  const std::size_t step = std::max<std::size_t>(ends.size() / kEnoughToTell, 1);
  for (std::size_t place = 0; place < ends.size(); place += step) {
    causes.add(Causes::evidence_of(response(history, ends[place]).parts));
  }
  causes.medians();
  bool usually_late = false;
  if (!lengths.empty() && !late.empty()) {
    const auto median = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), median, lengths.end());
    const auto shortest = std::min_element(
        late.begin(), late.end(), [](const Span& a, const Span& b) { return a.end - a.begin < b.end - b.begin; });
    usually_late = *median >= shortest->end - shortest->begin;
  }
  std::vector<CauseKind> kinds;
  for (const Span& each : late) {
    const std::optional<std::size_t> end = find(each);
    if (!end) {
      kinds.push_back(CauseKind::kUnexplained);
      continue;
    }
    const std::vector<Part> parts = response(history, *end).parts;
    Causes::Evidence evidence = Causes::evidence_of(parts);
    Causes::find_excesses(parts, history, evidence);
    kinds.push_back(causes.cause_of(evidence, history.app().graph, usually_late).kind);
  }
  return kinds;
}

bool Responses::counts(std::size_t end, const record::Interval& measured) const {
  return samples_[end].response && length(end) > Nanos{0} && measured.holds(samples_[end - 1].begin, samples_[end].end);
}

std::vector<double> Responses::lengths_ms(const record::Interval& measured) const {
  std::vector<double> lengths;
  for (std::size_t end = 1; end < samples_.size(); ++end) {
    if (counts(end, measured)) lengths.push_back(to_millis(length(end)).count());
  }
  return lengths;
}

void Responses::take_apart(const History& history, const record::Interval& measured, TimePoint until, Tally& tally) {
  for (; next_ < samples_.size() && samples_[next_].end <= until; ++next_) {
    if (counts(next_, measured)) tally.add(response(history, next_), history);
  }
}

// A response begins with the sample before the one that ends it. The first sample begins with one of the runs of the
// chain's first node that the tracker still knows.
std::optional<TimePoint> Responses::needs_from(const History& history) const {
  if (!samples_.empty()) return samples_[next_ - 1].begin;
  const std::span<const RunTimes> sources = history.runs(chain_.nodes.front());
  if (sources.size() <= record::ChainTracker::kHorizon) return std::nullopt;
  return sources[sources.size() - record::ChainTracker::kHorizon].begin;
}

void Responses::forget(const std::vector<std::size_t>& runs) {
  for (std::size_t stage = 0; stage < chain_.nodes.size(); ++stage) {
    std::vector<std::uint64_t>& taken = chain_.taken[stage];
    const std::size_t count = runs[chain_.nodes[stage].index()];
    if (count > 0) taken.erase(taken.begin() + 1, taken.begin() + 1 + static_cast<std::ptrdiff_t>(count));
  }
  if (next_ < 2) return;
  const std::size_t done = next_ - 1;
  samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(done));
  paths_.erase(paths_.begin(), paths_.begin() + static_cast<std::ptrdiff_t>(done * chain_.nodes.size()));
  next_ = 1;
}

}  // namespace ctn::why
