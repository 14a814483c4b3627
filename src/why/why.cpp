#include "why/why.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "base/text.h"
#include "record/app_changes.h"

namespace ctn::why {
namespace {

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

// Adds runs, and what was known of clocks when they ended.
template <class To>
Status add_runs(const record::Reader& record, To& to) {
  const auto clocks = record.clocks();
  if (!clocks) return clocks.error();
  auto reading = clocks->begin();
  return record.each_run([&](const record::Run& run) {
    for (; reading != clocks->end() && reading->at <= run.end; ++reading) to.add(*reading);
    to.add(run);
  });
}

template <class To>
Status add_others(const record::Reader& record, To& to) {
  const auto plans = record.plans();
  if (!plans) return plans.error();
  for (const record::PlanChange& change : *plans) {
    if (Status done = to.add(change); !done) return done;
  }
  const auto take = [&](const auto& event) { to.add(event); };
  if (Status done = record.each_trigger(take); !done) return done;
  if (Status done = record.each_slot(take); !done) return done;
  return record.each_steal(take);
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
  if (chains.empty()) return Error::caller("the app has no chain", "add a response_time to its objective");
  return Error::caller(
      fmt::format("{} is {}", quote(chain), found.empty() ? "none of the app's chains" : "the end of several chains"),
      fmt::format("name one by its number or its path: {}", fmt::join(chains, ", ")));
}

std::vector<std::size_t> chains_of(const graph::App& app) {
  std::vector<std::size_t> terms;
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric == graph::Metric::kResponseTime) terms.push_back(term);
  }
  return terms;
}

Analyser::Analyser(const graph::App& app, const std::vector<std::size_t>& terms, std::size_t cpus,
                   const record::Interval& measured)
    : app_(app), terms_(terms), measured_(measured), history_(app, cpus) {
  for (const std::size_t term : terms) chains_.emplace_back(app, term);
}

void Analyser::analyse_meanwhile(const Survey& survey, std::size_t worst, std::size_t step) {
  survey_ = &survey;
  step_ = step;
  left_ = step;
  history_.expect(survey.usual_cpu(), survey.knows_cpus());
  for (Responses& chain : chains_) chain.expect_clock(survey);
  expect(survey.lengths(), worst);
}

void Analyser::expect(const std::vector<Lengths>& lengths, std::size_t worst) {
  for (std::size_t chain = 0; chain < terms_.size(); ++chain) {
    tallies_.emplace_back(terms_[chain], app_.objective[terms_[chain]].max, lengths[chain], worst);
  }
}

void Analyser::add(const record::Run& run) {
  history_.add(run);
  for (Responses& chain : chains_) chain.add(run);
  if (survey_ == nullptr || --left_ > 0) return;
  // Runs that are still to come have not begun before then.
  take_apart(run.end - survey_->longest_run());
  forget();
  // Where much must be kept, since a response is long, it is not sorted again and again.
  left_ = std::max(step_, history_.size());
}

void Analyser::add(const record::ClockReading& reading) {
  history_.add(reading);
  for (Responses& chain : chains_) chain.add(reading);
}

void Analyser::take_apart(TimePoint until) {
  history_.sort();
  for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
    chains_[chain].take_apart(history_, measured_, until, tallies_[chain]);
  }
}

// What is asked about a response goes back to runs that were under way when it began, and to what kept these from their
// cores.
void Analyser::forget() {
  TimePoint needed = TimePoint::max();
  for (const Responses& chain : chains_) {
    const std::optional<TimePoint> from = chain.needs_from(history_);
    if (!from) return;
    needed = std::min(needed, *from);
  }
  const std::vector<std::size_t> forgotten = history_.forget_before(needed - 2 * survey_->longest_run());
  for (Responses& chain : chains_) chain.forget(forgotten);
}

std::vector<Analysis> Analyser::finish(std::size_t worst) {
  std::vector<Lengths> lengths;
  for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
    lengths.push_back(lengths_of(chains_[chain].lengths_ms(measured_), app_.objective[terms_[chain]].max));
  }
  expect(lengths, worst);
  return finish();
}

std::vector<Analysis> Analyser::finish() {
  take_apart(TimePoint::max());
  std::vector<Analysis> analyses;
  for (Tally& tally : tallies_) analyses.push_back(tally.finish(app_.graph));
  return analyses;
}

std::vector<std::vector<CauseKind>> Analyser::causes_of(const std::vector<std::vector<Span>>& late) {
  history_.sort();
  std::vector<std::vector<CauseKind>> causes;
  for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
    causes.push_back(chains_[chain].causes_of(history_, late[chain]));
  }
  return causes;
}

Status add_all_but_runs(const record::Reader& record, History& history) { return add_others(record, history); }

Result<std::vector<Analysis>> analyse(const record::Reader& record, const graph::App& app,
                                      const std::vector<std::size_t>& terms, const record::Interval& measured,
                                      const Survey& survey, std::size_t worst) {
  Analyser analyser(app, terms, record.header().cpus.size(), measured);
  analyser.analyse_meanwhile(survey, worst);
  if (Status done = add_others(record, analyser); !done) return done.error();
  if (Status done = add_runs(record, analyser); !done) return done.error();
  return analyser.finish();
}

Result<std::vector<Analysis>> analyse(const record::Reader& record, const std::vector<std::size_t>& terms,
                                      const Options& options) {
  const auto changes = record.app_changes();
  if (!changes) return changes.error();
  const Result<graph::App> app = record::app_after(record.app(), *changes);
  if (!app) return app.error();
  const record::Header& header = record.header();
  const TimePoint ended = record.ending().ended;
  const TimePoint begin = std::min(header.started + (options.whole ? Nanos{0} : header.warm_up), ended);
  const record::Interval measured{begin, ended};
  Survey survey(*app, terms, measured);
  if (Status done = add_runs(record, survey); !done) return done.error();
  survey.finish();
  return analyse(record, *app, terms, measured, survey, options.worst);
}

Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options) {
  auto analyses = analyse(record, std::vector<std::size_t>{term}, options);
  if (!analyses) return analyses.error();
  return std::move(analyses->front());
}

}  // namespace ctn::why
