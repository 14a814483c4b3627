#include "why/responses.h"

#include <algorithm>
#include <span>
#include <utility>

#include "base/statistics.h"
#include "why/causes.h"

namespace ctn::why {
namespace {

constexpr double kLatePercentile = 99.0;
constexpr int kUnexplainedPart = 50;  // at most one part in so many
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

Nanos unexplained(const std::vector<Part>& parts) {
  Nanos sum{0};
  for (const Part& part : parts) sum += part.kind == PartKind::kUnexplained ? part.length() : Nanos{0};
  return sum;
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
    const std::vector<std::uint64_t> path = tracker_.path_of(sample.source_run);
    samples_.push_back({sample, paths_.size()});
    paths_.insert(paths_.end(), path.begin(), path.end());
    paths_.resize(samples_.back().path + chain_.nodes.size());  // a path that is not known gets runs of number 0
  }
}

void Responses::add(const record::ClockReading& reading) {
  tracker_.set_clock(reading.node, reading.ticks);
  const NodeId first = app_.objective[term_].path.front();
  if (reading.node == first && app_.graph.node(first).external) chain_.begins_at_clock = true;
}

// Of each stage, the first run that the sample reached. The one that the next stage consumed may be a later one, which
// used the sample again while it waited there.
Way Responses::way(const History& history, const Known& known) const {
  Way way{known.sample, {}};
  for (std::size_t stage = 0; stage < chain_.nodes.size(); ++stage) {
    const std::optional<RunRef> run = history.find(chain_.nodes[stage], paths_[known.path + stage]);
    if (!run) return {known.sample, {}};
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
  const Known& known = samples_[end];
  const Known& before = samples_[end - 1];
  Response response{.begin = before.sample.begin, .end = known.sample.end, .source_run = known.sample.source_run};
  const Way way_before = way(history, before);
  const Way way_here = way(history, known);
  if (way_before.runs.empty() || way_here.runs.empty()) {
    response.parts = {{PartKind::kUnexplained, response.begin, response.end, chain_.nodes.front()}};
  } else {
    response.parts = Walk(history, chain_).take_apart(way_before, way_here);
  }
  return response;
}

std::optional<std::size_t> Responses::find(const Span& response) const {
  auto found = std::partition_point(samples_.begin(), samples_.end(),
                                    [&](const Known& known) { return known.sample.end < response.end; });
  for (; found != samples_.end() && found->sample.end == response.end; ++found) {
    if (found == samples_.begin() || !found->sample.response) continue;
    if ((found - 1)->sample.begin == response.begin) return static_cast<std::size_t>(found - samples_.begin());
  }
  return std::nullopt;
}

std::vector<CauseKind> Responses::causes_of(const History& history, std::span<const Span> late) const {
  std::vector<std::size_t> ends;
  std::vector<Nanos> lengths;
  for (std::size_t end = 1; end < samples_.size(); ++end) {
    if (!samples_[end].sample.response || length(end) <= Nanos{0}) continue;
    ends.push_back(end);
    lengths.push_back(length(end));
  }
  Causes causes;
  const std::size_t step = std::max<std::size_t>(ends.size() / kEnoughToTell, 1);
  for (std::size_t place = 0; place < ends.size(); place += step) causes.add(response(history, ends[place]).parts);
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
    kinds.push_back(end ? causes.cause_of(response(history, *end).parts, history, usually_late).kind
                        : CauseKind::kUnexplained);
  }
  return kinds;
}

Analysis Responses::analyse(const History& history, const record::Interval& measured, std::size_t worst) {
  Analysis analysis;
  analysis.term = term_;
  analysis.bound = app_.objective[term_].max;
  std::vector<std::size_t> ends;  // the samples that end a response which counts
  std::vector<double> lengths_ms;
  for (std::size_t end = 1; end < samples_.size(); ++end) {
    const TimePoint from = samples_[end - 1].sample.begin;
    const TimePoint until = samples_[end].sample.end;
    if (!samples_[end].sample.response || !measured.holds(from, until) || from >= until) continue;
    ends.push_back(end);
    lengths_ms.push_back(to_millis(until - from).count());
  }
  analysis.responses = ends.size();
  if (ends.empty()) return analysis;
  std::sort(lengths_ms.begin(), lengths_ms.end());
  analysis.late_over = analysis.bound.value_or(to_nanos(Millis{percentile_of_sorted(lengths_ms, kLatePercentile)}));
  analysis.response_ms = summarize(std::move(lengths_ms));

  Causes causes;
  for (const std::size_t end : ends) {
    const Response each = response(history, end);
    causes.add(each.parts);
    if (kUnexplainedPart * unexplained(each.parts) <= each.length()) ++analysis.explained;
  }
  for (const auto& [key, median] : causes.medians()) analysis.usual.push_back({key.first, key.second, median});
  std::stable_sort(analysis.usual.begin(), analysis.usual.end(),
                   [](const UsualPart& a, const UsualPart& b) { return a.median > b.median; });

  const bool usually_late = to_nanos(Millis{analysis.response_ms.p50}) > analysis.late_over;
  const auto explain = [&](Response& late) {
    late.late = true;
    late.cause = causes.cause_of(late.parts, history, usually_late);
  };
  for (const std::size_t end : ends) {
    if (length(end) <= analysis.late_over) continue;
    Response late = response(history, end);
    explain(late);
    ++analysis.late;
    ++analysis.causes[static_cast<std::size_t>(late.cause->kind)];
  }
  worst = std::min(worst, ends.size());
  std::partial_sort(
      ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(worst), ends.end(),
      [this](std::size_t a, std::size_t b) { return length(a) != length(b) ? length(a) > length(b) : a < b; });
  for (std::size_t place = 0; place < worst; ++place) {
    analysis.worst.push_back(response(history, ends[place]));
    if (length(ends[place]) > analysis.late_over) explain(analysis.worst.back());
  }
  return analysis;
}

}  // namespace ctn::why
