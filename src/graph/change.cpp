#include "graph/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/text.h"
#include "graph/ranking.h"
#include "graph/rules.h"

namespace ctn::graph {
namespace {

constexpr double kLowestHertz = 1e-5;  // as in an app file: a run of days
constexpr double kLongestMs = 10.0 * 24.0 * 3600.0 * 1000.0;

std::vector<std::string> names_of_path(std::string_view text) {
  constexpr std::string_view kArrow = "->";
  std::vector<std::string> names;
  while (true) {
    const auto arrow = text.find(kArrow);
    names.emplace_back(trimmed(text.substr(0, arrow)));
    if (arrow == std::string_view::npos) return names;
    text.remove_prefix(arrow + kArrow.size());
  }
}

std::optional<std::size_t> as_number(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

bool has_path(const App& app, const Term& term, const std::vector<std::string>& names) {
  return std::equal(term.path.begin(), term.path.end(), names.begin(), names.end(),
                    [&](NodeId node, const std::string& name) { return app.graph.node(node).name == name; });
}

bool has_ends(const App& app, const Term& term, const std::vector<std::string>& names) {
  return names.size() == 2 && app.graph.node(term.path.front()).name == names[0] &&
         app.graph.node(term.path.back()).name == names[1];
}

template <class Is>
std::vector<std::size_t> terms_that(const App& app, Metric metric, const Is& is) {
  std::vector<std::size_t> found;
  for (std::size_t index = 0; index < app.objective.size(); ++index) {
    if (app.objective[index].metric == metric && is(app.objective[index])) found.push_back(index);
  }
  return found;
}

std::string list_of_terms(const App& app) {
  constexpr std::size_t kNamed = 12;
  std::string list;
  for (std::size_t index = 0; index < std::min(app.objective.size(), kNamed); ++index) {
    list += fmt::format("{}{} ({})", index == 0 ? "" : ", ", index, term_name(app, app.objective[index]));
  }
  if (app.objective.size() > kNamed) list += fmt::format(" and {} more", app.objective.size() - kNamed);
  return list;
}

// The work of changed(): what is wrong is collected, and nothing is done where anything is.
class Changing {
 public:
  explicit Changing(const App& app) : before_(app), app_(app) {}

  Result<App> run(const Changes& changes) {
    for (const Changes::Weight& change : changes.weights) set_weight(change);
    check_sum_of_weights();
    for (const Changes::Max& change : changes.maxes) set_max(change);
    for (const Changes::MinRate& change : changes.min_rates) set_min_rate(change);
    for (const NodeId node : rates_changed_) check_rates(node);
    if (!problems_.empty()) return Error(ErrorKind::kCaller, std::move(problems_));
    if (before_.order == ordered_by_data_flow(before_)) app_.order = ordered_by_data_flow(app_);
    if (before_.steal.priority == ranked_by_weight(before_)) app_.steal.priority = ranked_by_weight(app_);
    return std::move(app_);
  }

 private:
  void problem(const std::string& key, const std::string& what, const std::string& hint) {
    problems_.push_back({{}, printable(key), printable(what), printable(hint)});
  }
  void problem(const std::optional<Problem>& found) {
    if (found) problem(found->key, found->what, found->hint);
  }

  std::optional<std::size_t> term(const std::string& name) {
    Result<std::size_t> found = find_term(before_, name);
    if (found) return *found;
    for (const Problem& each : found.error().problems()) problems_.push_back(each);
    return std::nullopt;
  }

  // Whether this is the first value that is given for it.
  bool is_new(const std::string& key) {
    if (seen_.insert(key).second) return true;
    problem(key, "it is changed twice", "give one value");
    return false;
  }

  void set_weight(const Changes::Weight& change) {
    const auto index = term(change.term);
    if (!index) return;
    const std::string key = fmt::format("objective[{}].weight", *index);
    if (!is_new(key)) return;
    problem(wrong_weight(key, change.weight));
    app_.objective[*index].weight = change.weight;
  }

  void check_sum_of_weights() {
    std::vector<double> weights;
    for (const Term& term : app_.objective) weights.push_back(term.weight);
    if (const auto wrong = wrong_sum_of_weights(weights)) problem(wrong->problem);
  }

  void set_max(const Changes::Max& change) {
    const auto index = term(change.term);
    if (!index) return;
    const std::string key = fmt::format("objective[{}].max", *index);
    if (!is_new(key)) return;
    Term& term = app_.objective[*index];
    if (term.metric == Metric::kPeriod) {
      return problem(key, "max bounds a response time; a period is bounded by a rate",
                     fmt::format("change the min_rate of node {}", app_.graph.node(term.path.front()).name));
    }
    if (!change.max_ms) return term.max.reset();
    const bool in_range = *change.max_ms > 0.0 && *change.max_ms <= kLongestMs;  // false for what is no number, too
    const Nanos max = in_range ? to_nanos(Millis{*change.max_ms}) : Nanos{0};
    if (max <= Nanos{0}) {
      return problem(key, fmt::format("a bound of {} ms is out of range", *change.max_ms),
                     "write more than 0, as in 60ms; or take the bound away: none");
    }
    term.max = max;
  }

  void set_min_rate(const Changes::MinRate& change) {
    const std::string key = fmt::format("nodes.{}.min_rate", change.node);
    const std::optional<NodeId> node = before_.graph.find_node(change.node);
    if (!node) {
      std::vector<std::string> names;
      for (const Node& each : before_.graph.nodes()) names.push_back(each.name);
      const auto meant = nearest(change.node, names);
      return problem(key, fmt::format("there is no node {}", quote(change.node)),
                     meant ? fmt::format("did you mean {}?", quote(*meant)) : "use a name from the app's nodes");
    }
    if (!is_new(key)) return;
    if (!before_.graph.node(*node).subchain) {
      return problem(key,
                     fmt::format("node {} is not scheduled: its rate is not Catan's to choose", quote(change.node)),
                     "name a scheduled node");
    }
    std::optional<Rate> rate;
    if (change.min_rate_hz) {
      if (!(*change.min_rate_hz >= kLowestHertz && *change.min_rate_hz <= kHighestTriggerRate.hertz())) {
        return problem(key, fmt::format("a rate of {} Hz is out of range", *change.min_rate_hz),
                       "write one from 0.00001 to 10000, as in 10Hz; or take the bound away: none");
      }
      rate = Rate{*change.min_rate_hz};
    }
    app_.graph = app_.graph.with_min_rate(*node, rate);
    rates_changed_.push_back(*node);
  }

  // All nodes of a subchain run at one rate.
  void check_rates(NodeId id) {
    const Node& node = app_.graph.node(id);
    if (!node.min_rate) return;
    const std::string key = fmt::format("nodes.{}.min_rate", node.name);
    const Subchain& subchain = app_.graph.subchain(*node.subchain);
    problem(rate_above_outputs(app_.graph, id, *node.min_rate, "ask for less"));
    problem(exact_rate_by_arrival(key, app_.graph, subchain, "ask for a min_rate below the max_rate"));
    for (const NodeId other : subchain.nodes) {
      const Node& capped = app_.graph.node(other);
      if (!capped.max_rate || *node.min_rate <= *capped.max_rate) continue;
      problem(key,
              fmt::format("{}Hz is above the max_rate of {} ({}Hz), and both run at the rate of subchain {}",
                          node.min_rate->hertz(), quote(capped.name), capped.max_rate->hertz(), quote(subchain.name)),
              "ask for less");
    }
  }

  const App& before_;
  App app_;
  std::vector<NodeId> rates_changed_;
  std::set<std::string> seen_;
  std::vector<Problem> problems_;
};

}  // namespace

std::string term_name(const App& app, const Term& term) {
  const std::string path = app.graph.path_name(term.path);
  return term.metric == Metric::kPeriod ? "period of " + path : path;
}

Result<std::size_t> find_term(const App& app, std::string_view name) {
  const std::string key = printable(name);
  const auto refused = [&](std::string what, std::string hint) {
    return Error(ErrorKind::kCaller, {{{}, key, std::move(what), std::move(hint)}});
  };
  if (const auto number = as_number(trimmed(name))) {
    if (*number < app.objective.size()) return *number;
    return refused(fmt::format("the objective has terms 0 to {}", app.objective.size() - 1),
                   "choose from " + list_of_terms(app));
  }
  constexpr std::string_view kPeriodOf = "period of ";
  const bool says_period = name.starts_with(kPeriodOf);
  const std::vector<std::string> names = names_of_path(says_period ? name.substr(kPeriodOf.size()) : name);
  const auto whole = [&](const Term& term) { return has_path(app, term, names); };
  std::vector<std::size_t> found;
  if (!says_period) found = terms_that(app, Metric::kResponseTime, whole);
  if (found.empty()) found = terms_that(app, Metric::kPeriod, whole);
  if (found.empty()) {
    found = terms_that(app, Metric::kResponseTime, [&](const Term& term) { return has_ends(app, term, names); });
  }
  if (found.size() == 1) return found.front();
  return refused(found.empty() ? "the objective has no such term" : "several chains of the objective have these ends",
                 "choose from " + list_of_terms(app));
}

Result<App> changed(const App& app, const Changes& changes) { return Changing(app).run(changes); }

}  // namespace ctn::graph
