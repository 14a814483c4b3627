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
    : measured_(measured), history_(std::make_shared<History>(app, cpus)) {
  for (const std::size_t term : terms) chains_.emplace_back(app, term);
}

Status Analyser::add_all_but_runs(const record::Reader& record) {
  const auto plans = record.plans();
  if (!plans) return plans.error();
  for (const record::PlanChange& change : *plans) {
    if (Status done = add(change); !done) return done;
  }
  const auto take = [this](const auto& event) { add(event); };
  if (Status done = record.each_trigger(take); !done) return done;
  if (Status done = record.each_slot(take); !done) return done;
  return record.each_steal(take);
}

void Analyser::add(const record::Run& run) {
  history_->add(run);
  for (Responses& chain : chains_) chain.add(run);
}

void Analyser::add(const record::ClockReading& reading) {
  history_->add(reading);
  for (Responses& chain : chains_) chain.add(reading);
}

std::vector<Analysis> Analyser::finish(std::size_t worst) {
  history_->sort();
  std::vector<Analysis> analyses;
  for (Responses& chain : chains_) analyses.push_back(chain.analyse(*history_, measured_, worst));
  return analyses;
}

std::vector<std::vector<CauseKind>> Analyser::causes_of(const std::vector<std::vector<Span>>& late) {
  history_->sort();
  std::vector<std::vector<CauseKind>> causes;
  for (std::size_t chain = 0; chain < chains_.size(); ++chain) {
    causes.push_back(chains_[chain].causes_of(*history_, late[chain]));
  }
  return causes;
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
  Analyser analyser(*app, terms, header.cpus.size(), {begin, ended});
  if (Status done = analyser.add_all_but_runs(record); !done) return done.error();
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

Result<Analysis> analyse(const record::Reader& record, std::size_t term, const Options& options) {
  auto analyses = analyse(record, std::vector<std::size_t>{term}, options);
  if (!analyses) return analyses.error();
  return std::move(analyses->front());
}

}  // namespace ctn::why
