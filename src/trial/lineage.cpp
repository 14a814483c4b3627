#include "trial/lineage.h"

#include <algorithm>

namespace ctn::trial {

ChainPrefixes::ChainPrefixes(const graph::App& app) : of_node_(app.graph.nodes().size()) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    if (app.objective[term].metric != graph::Metric::kResponseTime) continue;
    int prefix = -1;
    for (const NodeId node : app.objective[term].path) {
      if (!app.graph.node(node).external) prefix = find_or_add(app.graph, node, prefix);
    }
    prefixes_[static_cast<std::size_t>(prefix)].terms.push_back(static_cast<int>(term));
  }
}

int ChainPrefixes::find_or_add(const graph::Graph& graph, NodeId node, int before) {
  std::vector<int>& of_node = of_node_[node.index()];
  const auto found = std::find_if(of_node.begin(), of_node.end(), [&](int index) {
    return prefixes_[static_cast<std::size_t>(index)].before == before;
  });
  if (found != of_node.end()) return *found;
  const int added = static_cast<int>(prefixes_.size());
  Prefix prefix{.node = node, .before = before, .queues = {}, .terms = {}};
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

Lineage::Lineage(const graph::App& app, const ChainPrefixes& prefixes, TimePoint warm_from, bool keep_values)
    : prefixes_(prefixes),
      warm_from_(warm_from),
      keep_values_(keep_values),
      held_(prefixes.all().size(), kNone),
      given_(prefixes.all().size(), kNone),
      batches_(prefixes.all().size()),
      reached_(app.objective.size(), kNone),
      periods_(app.graph.nodes().size()),
      terms_(app.objective.size()) {
  for (std::size_t term = 0; term < app.objective.size(); ++term) {
    const graph::Term& of = app.objective[term];
    if (of.metric == graph::Metric::kPeriod) periods_[of.path.front().index()].terms.push_back(static_cast<int>(term));
  }
}

void Lineage::begin(NodeId node, TimePoint now) {
  for (const int number : prefixes_.of(node)) {
    const auto index = static_cast<std::size_t>(number);
    const Prefix& prefix = prefixes_.all()[index];
    if (prefix.before < 0) {
      held_[index] = now;
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
  if (!period.terms.empty()) {
    if (period.last_end != kNone) {
      for (const int term : period.terms) add(term, period.last_end, now);
    }
    period.last_end = now;
  }
  if (!emitted) return;
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
  if (source != kNone && !prefix.terms.empty()) reach_end(prefix, source, now);
}

void Lineage::give_many(std::size_t index, const Prefix& prefix, TimePoint now) {
  Batches& here = batches_[index];
  const Sources& sources = here.held;
  if (prefix.extended) here.given = sources;
  for (const int queue : prefix.queues) {
    put_in_queue(batches_[static_cast<std::size_t>(queue)], sources.data(), sources.data() + sources.size());
  }
  if (prefix.terms.empty()) return;
  for (const TimePoint source : sources) reach_end(prefix, source, now);
}

// What is used again by one output after another waits only once.
void Lineage::put_in_queue(Batches& queue, const TimePoint* first, const TimePoint* last) {
  if (queue.outputs_waiting == kQueueCapacity) return;
  ++queue.outputs_waiting;
  for (; first != last; ++first) {
    if (queue.waiting.empty() || queue.waiting.back() < *first) queue.waiting.push_back(*first);
  }
}

// An output descends from that source run, and is its first one unless a newer one has reached the end.
void Lineage::reach_end(const Prefix& prefix, TimePoint source, TimePoint now) {
  for (const int term : prefix.terms) {
    TimePoint& reached = reached_[static_cast<std::size_t>(term)];
    if (source <= reached) continue;
    if (reached != kNone) add(term, reached, now);
    reached = source;
  }
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
