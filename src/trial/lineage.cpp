#include "trial/lineage.h"

#include <algorithm>
#include <utility>

namespace ctn::trial {

ChainPrefixes::ChainPrefixes(const graph::App& app) : of_node_(app.graph.nodes().size()) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    const std::vector<NodeId>& path = app.objective[term].path;
    std::optional<NodeId> clock;
    if (app.graph.node(path.front()).is_external_clock()) clock = path.front();
    int prefix = -1;
    for (const NodeId node : path) {
      if (app.graph.node(node).external) continue;
      prefix = find_or_add(app.graph, node, prefix, prefix < 0 ? clock : std::nullopt);
    }
    prefixes_[static_cast<std::size_t>(prefix)].terms.push_back(static_cast<int>(term));
  }
}

int ChainPrefixes::find_or_add(const graph::Graph& graph, NodeId node, int before, std::optional<NodeId> clock) {
  std::vector<int>& of_node = of_node_[node.index()];
  const auto found = std::find_if(of_node.begin(), of_node.end(), [&](int index) {
    const Prefix& known = prefixes_[static_cast<std::size_t>(index)];
    return known.before == before && known.clock == clock;
  });
  if (found != of_node.end()) return *found;
  const int added = static_cast<int>(prefixes_.size());
  Prefix prefix{.node = node, .before = before, .clock = clock, .queues = {}, .terms = {}};
  if (before >= 0) {
    Prefix& extended = prefixes_[static_cast<std::size_t>(before)];
    prefix.queue = graph.node(node).input == graph::InputKind::kQueue;
    prefix.many = prefix.queue || extended.many;
    if (prefix.queue) {
      extended.queues.push_back(added);
    } else {
      extended.extended = true;
    }
  }
  prefixes_.push_back(std::move(prefix));
  of_node.push_back(added);
  return added;
}

Lineage::Lineage(const graph::App& app, const ChainPrefixes& prefixes, std::vector<Ticks> clocks, TimePoint warm_from,
                 Nanos before_ticks, bool keep_values)
    : prefixes_(prefixes),
      clocks_(std::move(clocks)),
      before_ticks_(before_ticks),
      warm_from_(warm_from),
      keep_values_(keep_values),
      held_(prefixes.all().size(), kNone),
      given_(prefixes.all().size(), kNone),
      batches_(prefixes.all().size()),
      ends_(app.objective.size()),
      periods_(app.graph.nodes().size()),
      feeds_(app.graph.nodes().size()),
      terms_(app.objective.size()) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    const graph::Term& of = app.objective[term];
    if (app.graph.node(of.path.back()).is_external_clock()) ends_[term].clock = clocks_[of.path.back().index()];
    if (of.metric == graph::Metric::kPeriod) add_period_term(app.graph, of.path.front(), static_cast<int>(term));
  }
}

void Lineage::add_period_term(const graph::Graph& graph, NodeId node, int term) {
  PeriodTerms& period = periods_[node.index()];
  period.terms.push_back(term);
  if (period.may_run_empty || !graph.may_run_empty(node)) return;
  period.may_run_empty = true;
  for (const NodeId input : graph.node(node).predecessors) feeds_[input.index()].push_back(node.index());
}

void Lineage::begin(NodeId node, TimePoint now) {
  PeriodTerms& period = periods_[node.index()];
  if (period.may_run_empty) period.had_input = std::exchange(period.fed, false);
  for (const int number : prefixes_.of(node)) {
    const auto index = static_cast<std::size_t>(number);
    const Prefix& prefix = prefixes_.all()[index];
    if (prefix.before < 0) {
      held_[index] = prefix.clock ? clocks_[prefix.clock->index()].last(now) : now;
    } else if (!prefix.many) {
      held_[index] = given_[static_cast<std::size_t>(prefix.before)];
    } else {
      take(index, prefix);
    }
  }
}

// Where a batch may be taken, or has been.
void Lineage::take(std::size_t index, const Prefix& prefix) {
  Batches& here = batches_[index];
  if (prefix.queue) {
    here.held.clear();
    std::swap(here.held, here.waiting);
    here.outputs_waiting = 0;
  } else {
    here.held = batches_[static_cast<std::size_t>(prefix.before)].given;
  }
}

void Lineage::end(NodeId node, TimePoint now, bool emitted) {
  PeriodTerms& period = periods_[node.index()];
  if (!period.terms.empty() && period.had_input) {
    if (period.last_end != kNone) {
      for (const int term : period.terms) add(term, period.last_end, now);
    }
    period.last_end = now;
  }
  if (!emitted) return;
  for (const std::size_t fed : feeds_[node.index()]) periods_[fed].fed = true;
  for (const int number : prefixes_.of(node)) {
    const auto index = static_cast<std::size_t>(number);
    const Prefix& prefix = prefixes_.all()[index];
    prefix.many ? give_many(index, prefix, now) : give(index, prefix, now);
  }
}

void Lineage::give(std::size_t index, const Prefix& prefix, TimePoint now) {
  const TimePoint source = held_[index];
  if (prefix.extended) given_[index] = source;
  for (const int queue : prefix.queues) {
    put_in_queue(batches_[static_cast<std::size_t>(queue)], &source, &source + (source == kNone ? 0 : 1));
  }
  if (source != kNone && !prefix.terms.empty()) reach_end(prefix, &source, &source + 1, now);
}

void Lineage::give_many(std::size_t index, const Prefix& prefix, TimePoint now) {
  Batches& here = batches_[index];
  const Sources& sources = here.held;
  if (prefix.extended) here.given = sources;
  for (const int queue : prefix.queues) {
    put_in_queue(batches_[static_cast<std::size_t>(queue)], sources.data(), sources.data() + sources.size());
  }
  if (prefix.terms.empty()) return;
  reach_end(prefix, sources.data(), sources.data() + sources.size(), now);
}

// What is used again by one output after another waits only once.
void Lineage::put_in_queue(Batches& queue, const TimePoint* first, const TimePoint* last) {
  if (queue.outputs_waiting == kQueueCapacity) return;
  ++queue.outputs_waiting;
  for (; first != last; ++first) {
    if (queue.waiting.empty() || queue.waiting.back() < *first) queue.waiting.push_back(*first);
  }
}

// An output descends from those source runs.
void Lineage::reach_end(const Prefix& prefix, const TimePoint* first, const TimePoint* last, TimePoint now) {
  for (const int term : prefix.terms) {
    if (ends_[static_cast<std::size_t>(term)].clock.period > Nanos{0}) {
      wait_for_tick(term, first, last, now);
    } else {
      for (const TimePoint* source = first; source != last; ++source) reach(term, *source, now);
    }
  }
}

// It is the source run's first output, unless a newer one has reached the end.
void Lineage::reach(int term, TimePoint source, TimePoint now) {
  TimePoint& reached = ends_[static_cast<std::size_t>(term)].reached;
  if (source <= reached) return;
  if (reached != kNone) add(term, reached, now);
  reached = source;
}

void Lineage::wait_for_tick(int term, const TimePoint* first, const TimePoint* last, TimePoint now) {
  End& end = ends_[static_cast<std::size_t>(term)];
  const TimePoint tick = end.clock.next(now + before_ticks_);
  if (end.tick < tick) {
    for (const TimePoint source : end.waiting) reach(term, source, end.tick);
    end.waiting.clear();
    end.tick = tick;
  }
  first = std::upper_bound(first, last, end.newest);
  if (first == last) return;
  end.waiting.assign(first, last);
  end.newest = end.waiting.back();
}

void Lineage::add(int term, TimePoint from, TimePoint to) {
  if (from < warm_from_) return;
  TermSamples& samples = terms_[static_cast<std::size_t>(term)];
  const auto value = static_cast<double>((to - from).count());
  samples.sum += value;
  ++samples.count;
  if (keep_values_) samples.values.push_back(value);
}

}  // namespace ctn::trial
