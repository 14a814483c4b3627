#include "why/why.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "base/statistics.h"
#include "base/text.h"
#include "record/app_changes.h"
#include "why/causes.h"

namespace ctn::why {
namespace {

constexpr double kLatePercentile = 99.0;
constexpr int kUnexplainedPart = 50;  // at most one part in so many

std::vector<std::string> nodes_written(std::string_view path) {
  std::vector<std::string> nodes;
  while (true) {
    const std::size_t arrow = path.find('>');
    std::string_view node = path.substr(0, arrow);
    if (arrow != std::string_view::npos && node.ends_with('-')) node.remove_suffix(1);
    nodes.emplace_back(trimmed(node));
    if (arrow == std::string_view::npos) return nodes;
    path.remove_prefix(arrow + 1);
  }
}

std::vector<std::string> node_names(const graph::App& app, const graph::Term& term) {
  std::vector<std::string> names;
  for (const NodeId node : term.path) names.push_back(app.graph.node(node).name);
  return names;
}

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

Result<std::size_t> find_chain(const graph::App& app, std::string_view chain) {
  const std::vector<std::string> wanted = nodes_written(trimmed(chain));
  std::vector<std::size_t> found;
  std::vector<std::string> chains;
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const std::vector<std::string> names = node_names(app, app.objective[term]);
    chains.push_back(fmt::format("{} ({})", term, app.graph.path_name(app.objective[term].path)));
    if (wanted.size() == 1 && wanted.front() == std::to_string(term)) return term;
    if (wanted == names) return term;
    if (wanted.size() == 1 && wanted.front() == names.back()) found.push_back(term);
  }
  if (found.size() == 1) return found.front();
  if (chains.empty()) return Error::caller("the app has no chain", "a chain is a response_time of its objective");
  return Error::caller(
      fmt::format("{} is {}", quote(chain), found.empty() ? "none of the app's chains" : "the end of several chains"),
      fmt::format("name one by its number or its path: {}", fmt::join(chains, ", ")));
}

Analyser::Analyser(const graph::App& app, std::size_t term, std::size_t cpus, const record::Interval& measured)
    : app_(app),
      term_(term),
      measured_(measured),
      history_(app, cpus),
      chain_(stages_of(app, term)),
      tracker_(app.graph, app.objective[term].path) {}

std::optional<std::size_t> Analyser::stage_of(NodeId node) const {
  const auto found = std::find(chain_.nodes.begin(), chain_.nodes.end(), node);
  if (found == chain_.nodes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - chain_.nodes.begin());
}

void Analyser::add(const record::Run& run) {
  history_.add(run);
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
    paths_.resize(samples_.back().path + chain_.nodes.size());  // one that is not known has runs of number 0
  }
}

void Analyser::add(const record::ClockReading& reading) {
  history_.add(reading);
  tracker_.set_clock(reading.node, reading.ticks);
  const NodeId first = app_.objective[term_].path.front();
  if (reading.node == first && app_.graph.node(first).external) chain_.begins_at_clock = true;
}

// By the runs by which the sample came to each stage first: those that were consumed further on may be later ones,
// which used it again while it waited there.
Way Analyser::way(const Known& known) const {
  Way way{known.sample, {}};
  for (std::size_t stage = 0; stage < chain_.nodes.size(); ++stage) {
    const std::optional<RunRef> run = history_.find(chain_.nodes[stage], paths_[known.path + stage]);
    if (!run) return {known.sample, {}};
    way.runs.push_back(run->index);
  }
  for (std::size_t stage = 1; stage + 1 < chain_.nodes.size(); ++stage) {
    const std::span<const RunTimes> runs = history_.runs(chain_.nodes[stage]);
    const std::uint64_t taken = history_.run({chain_.nodes[stage - 1], way.runs[stage - 1]}).number;
    for (std::size_t index = way.runs[stage]; index > 0 && chain_.taken[stage][index - 1] >= taken; --index) {
      if (runs[index - 1].emitted) way.runs[stage] = index - 1;
    }
  }
  return way;
}

Response Analyser::response(std::size_t index) {
  const Known& known = samples_[ends_[index]];
  const Known& before = samples_[ends_[index] - 1];
  Response response{.begin = before.sample.begin,
                    .end = known.sample.end,
                    .source_run = known.sample.source_run,
                    .late = known.sample.end - before.sample.begin > late_over_,
                    .cause = index < causes_.size() ? causes_[index] : std::nullopt,
                    .parts = {}};
  const Way way_before = way(before);
  const Way way_here = way(known);
  if (way_before.runs.empty() || way_here.runs.empty()) {
    response.parts = {{PartKind::kUnexplained, response.begin, response.end, chain_.nodes.front()}};
  } else {
    response.parts = Walk(history_, chain_).take_apart(way_before, way_here);
  }
  return response;
}

Analysis Analyser::finish(std::size_t worst) {
  history_.sort();
  Analysis analysis;
  analysis.term = term_;
  analysis.bound = app_.objective[term_].max;
  std::vector<double> lengths_ms;
  for (std::size_t index = 1; index < samples_.size(); ++index) {
    const TimePoint begin = samples_[index - 1].sample.begin;
    const TimePoint end = samples_[index].sample.end;
    if (!samples_[index].sample.response || !measured_.holds(begin, end) || begin >= end) continue;
    ends_.push_back(index);
    lengths_ms.push_back(to_millis(end - begin).count());
  }
  analysis.responses = ends_.size();
  if (ends_.empty()) return analysis;
  std::vector<double> sorted = lengths_ms;
  std::sort(sorted.begin(), sorted.end());
  late_over_ = analysis.bound.value_or(to_nanos(Millis{percentile_of_sorted(sorted, kLatePercentile)}));
  analysis.late_over = late_over_;
  analysis.response_ms = summarize(std::move(sorted));

  Causes causes;
  for (std::size_t index = 0; index < ends_.size(); ++index) {
    const Response each = response(index);
    causes.add(each.parts);
    if (kUnexplainedPart * unexplained(each.parts) <= each.length()) ++analysis.explained;
  }
  const bool usually_late = to_nanos(Millis{analysis.response_ms.p50}) > late_over_;
  for (const auto& [key, median] : causes.medians()) analysis.usual.push_back({key.first, key.second, median});
  std::stable_sort(analysis.usual.begin(), analysis.usual.end(),
                   [](const UsualPart& a, const UsualPart& b) { return a.median > b.median; });
  causes_.resize(ends_.size());
  for (std::size_t index = 0; index < ends_.size(); ++index) {
    Response each = response(index);
    if (!each.late) continue;
    causes_[index] = causes.cause_of(each.parts, history_, usually_late);
    ++analysis.late;
    ++analysis.causes[static_cast<std::size_t>(causes_[index]->kind)];
  }
  std::vector<std::size_t> longest(ends_.size());
  std::iota(longest.begin(), longest.end(), std::size_t{0});
  worst = std::min(worst, longest.size());
  std::partial_sort(longest.begin(), longest.begin() + static_cast<std::ptrdiff_t>(worst), longest.end(),
                    [&](std::size_t a, std::size_t b) {
                      return lengths_ms[a] != lengths_ms[b] ? lengths_ms[a] > lengths_ms[b] : a < b;
                    });
  for (std::size_t place = 0; place < worst; ++place) analysis.worst.push_back(response(longest[place]));
  return analysis;
}

Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options) {
  const auto changes = record.app_changes();
  if (!changes) return changes.error();
  const Result<graph::App> app = record::app_after(record.app(), *changes);
  if (!app) return app.error();
  const record::Header& header = record.header();
  const TimePoint ended = record.ending().ended;
  const TimePoint begin = std::min(header.started + (options.whole ? Nanos{0} : header.warm_up), ended);
  Analyser analyser(*app, term, header.cpus.size(), {begin, ended});

  const auto plans = record.plans();
  if (!plans) return plans.error();
  for (const record::PlanChange& change : *plans) {
    if (Status done = analyser.add(change); !done) return done.error();
  }
  const auto take = [&](const auto& event) { analyser.add(event); };
  if (Status done = record.each_trigger(take); !done) return done.error();
  if (Status done = record.each_slot(take); !done) return done.error();
  if (Status done = record.each_steal(take); !done) return done.error();
  const auto clocks = record.clocks();
  if (!clocks) return clocks.error();
  auto reading = clocks->begin();
  const Status done = record.each_run([&](const record::Run& run) {
    for (; reading != clocks->end() && reading->at <= run.end; ++reading) analyser.add(*reading);
    analyser.add(run);
  });
  if (!done) return done.error();
  return analyser.finish(options.worst);
}

}  // namespace ctn::why
