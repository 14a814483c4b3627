#include "common/inferred_graph.h"

#include <algorithm>
#include <array>
#include <set>

#include "common/observed_figures.h"

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;

// Half of the runs are below that of a callback that does no more than keep a message.
constexpr nanoseconds kKeepsOnly = std::chrono::microseconds{300};
constexpr std::size_t kMaxName = 90;
// Sets of messages, as message_filters makes them: of the fewest messages that come of one kind, so many at least, and
// at most, are completed. Else callbacks publish each for itself.
constexpr double kMinSets = 0.8;
constexpr double kMaxSets = 1.1;
// One callback completes so many of the sets that what the others complete does not matter.
constexpr double kMostSets = 0.8;
// Callbacks that so large a part of their runs is by turns, of so many runs at least, are called for one set each time.
constexpr double kByTurns = 0.9;
constexpr std::size_t kMinTurns = 5;
// A run that begins within so much of the median interval after the one before is of a message that came twice: roscpp
// now and then has two connections for one topic in a program.
constexpr double kSameMessage = 0.25;
// How much more often than messages come a callback may run: so that one that was late once runs as soon as its message
// is there again, some runs later.
constexpr double kCatchesUp = 1.1;

bool contains(const std::vector<std::string>& list, const std::string& one) {
  return std::find(list.begin(), list.end(), one) != list.end();
}

bool same_callback(const ObservedCallback& a, const ObservedCallback& b) {
  return of_one_program(a, b) && a.kind == b.kind && a.name == b.name && a.period == b.period;
}

// Whether runs of both are among one another. Runs are in the order in which they ended. Precondition: there are some.
bool overlap(const ObservedCallback& a, const ObservedCallback& b) {
  return a.runs.front().begin <= b.runs.back().begin && b.runs.front().begin <= a.runs.back().begin;
}

// Once for each message.
std::vector<nanoseconds> begins_of(const ObservedCallback& callback) {
  const auto repeated =
      std::chrono::duration_cast<nanoseconds>(median_interval(callback).value_or(nanoseconds{0}) * kSameMessage);
  std::vector<nanoseconds> begins;
  for (const ObservedRun& run : callback.runs) begins.push_back(run.begin);
  std::sort(begins.begin(), begins.end());
  const auto same = [repeated](nanoseconds first, nanoseconds second) { return second - first <= repeated; };
  begins.erase(std::unique(begins.begin(), begins.end(), same), begins.end());
  return begins;
}

bool are_among_one_another(const std::vector<const ObservedCallback*>& callbacks) {
  for (auto one = callbacks.begin(); one != callbacks.end(); ++one) {
    if (std::any_of(one + 1, callbacks.end(), [&](const ObservedCallback* other) { return overlap(**one, *other); })) {
      return true;
    }
  }
  return false;
}

// Whether now the one is called and now the other.
bool by_turns(const ObservedCallback& a, const ObservedCallback& b) {
  if (std::min(a.runs.size(), b.runs.size()) < kMinTurns) return false;
  std::vector<std::pair<nanoseconds, bool>> begins;
  for (const nanoseconds begin : begins_of(a)) begins.emplace_back(begin, false);
  for (const nanoseconds begin : begins_of(b)) begins.emplace_back(begin, true);
  std::sort(begins.begin(), begins.end());
  std::size_t changes = 0;
  for (std::size_t run = 1; run < begins.size(); ++run) {
    if (begins[run].second != begins[run - 1].second) ++changes;
  }
  return static_cast<double>(changes) >= kByTurns * static_cast<double>(begins.size() - 1);
}

double seconds_of(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

std::size_t publishing_runs(const ObservedCallback& callback) {
  return static_cast<std::size_t>(std::count_if(callback.runs.begin(), callback.runs.end(),
                                                [](const ObservedRun& run) { return !run.published.empty(); }));
}

bool is_light(const ObservedCallback& callback) {
  return !publishes(callback) && cost_percentile(callback, 0.5) < kKeepsOnly;
}

}  // namespace

std::string last_part(const std::string& name) { return name.substr(name.rfind('/') + 1); }

InferredGraph::InferredGraph(const std::vector<ObservedCallback>& callbacks, const Connections& connections)
    : callbacks_(callbacks), connections_(connections) {
  find_candidates();
  find_sets();
  find_nodes();
  find_edges();
  name_vertices();
  take_edges();
  sort_vertices();
  bound_rates();
}

// Callbacks of one program that have one name cannot be told apart by a binding, which names the first. If runs of any
// two are among one another, none of them can be a node: were the first one, the others would wait behind all nodes.
// Else each has taken the place of the one before, since its program subscribed again, and the first stands for all.
void InferredGraph::find_candidates() {
  std::set<const ObservedCallback*> others;  // of a name whose first one has been looked at
  for (const ObservedCallback& callback : callbacks_) {
    const bool called = !callback.runs.empty();
    if (callback.kind == Binding::Kind::kService) {
      if (called) remarks_.push_back(described(callback) + " is left as it is; bind it if it matters");
      continue;
    }
    if (!called) {
      remarks_.push_back(described(callback) + " was not called");
      continue;
    }
    if (others.count(&callback) > 0) continue;
    const Callbacks alike = called_alike(callback);
    others.insert(alike.begin(), alike.end());
    if (are_among_one_another(alike)) {
      remarks_.push_back(described(callback) + " is there " + std::to_string(alike.size()) +
                         " times, and which is which cannot be told: all are left as they are; in programs of their "
                         "own they can be nodes");
      continue;
    }
    candidates_.push_back(&callback);
    if (alike.size() > 1) remarks_.push_back(described(callback) + " is there more than once; the first is the node");
  }
}

// Those that were called, itself among them.
InferredGraph::Callbacks InferredGraph::called_alike(const ObservedCallback& callback) const {
  Callbacks alike;
  for (const ObservedCallback& other : callbacks_) {
    if (!other.runs.empty() && same_callback(callback, other)) alike.push_back(&other);
  }
  return alike;
}

bool InferredGraph::is_candidate(const ObservedCallback& callback) const {
  return std::find(candidates_.begin(), candidates_.end(), &callback) != candidates_.end();
}

// A synchronizer publishes in the callback of whichever message completes a set: callbacks of one program publish on
// one topic, and all together hardly more often than each is called. The one that is behind all others is to be the
// node, whichever came last while they were observed: when it runs, the others have come. Else it is the one that
// mostly came last, if there is one.
//
// In a nodelet, callbacks are of a set, too, that completed none while they were observed (keepers_beside()). Which one
// was last, always or mostly, was their senders' order then, which is another under Catan: unless one sends all of
// them, any may be.
void InferredGraph::find_sets() {
  for (const ObservedCallback& callback : callbacks_) {
    std::set<std::string> topics;
    for (const ObservedRun& run : callback.runs) topics.insert(run.published.begin(), run.published.end());
    for (const std::string& topic : topics) publishing_[topic].push_back(&callback);
  }
  std::map<std::array<std::string, 3>, Callbacks> of_topic;  // by ROS node, nodelet and topic
  for (const auto& [topic, callbacks] : publishing_) {
    for (const ObservedCallback* const callback : callbacks) {
      if (callback->kind != Binding::Kind::kTopic || !is_candidate(*callback)) continue;
      of_topic[{callback->ros_node, callback->nodelet, topic}].push_back(callback);
    }
  }
  for (const auto& [where, callbacks] : of_topic) find_set(callbacks, where[2]);
  for (const auto& [callback, completing] : completed_by_) any_completes_.erase(callback);
}

// Of callbacks of one program that publish on `topic`, and can be nodes.
void InferredGraph::find_set(Callbacks callbacks, const std::string& topic) {
  const Callbacks keepers = keepers_beside(callbacks);
  callbacks.insert(callbacks.end(), keepers.begin(), keepers.end());
  const auto published = [&](const ObservedCallback* one) { return count_published(*one, topic); };
  std::size_t completed = 0;
  std::size_t fewest = callbacks.front()->runs.size();
  for (const ObservedCallback* const one : callbacks) {
    completed += published(one);
    fewest = std::min(fewest, one->runs.size());
  }
  const double sets = static_cast<double>(completed) / static_cast<double>(fewest);
  if (callbacks.size() < 2 || sets < kMinSets || sets > kMaxSets) return;
  const auto less = [&](const ObservedCallback* a, const ObservedCallback* b) { return published(a) < published(b); };
  const auto behind_all = std::find_if(callbacks.begin(), callbacks.end(), [&](const ObservedCallback* one) {
    return is_candidate(*one) && std::all_of(callbacks.begin(), callbacks.end(), [&](const ObservedCallback* other) {
             return other == one || is_behind(*one, *other);
           });
  });
  const bool found = behind_all != callbacks.end();
  const ObservedCallback* const last =
      found ? *behind_all : *std::max_element(callbacks.begin(), callbacks.end(), less);
  const bool mostly = static_cast<double>(published(last)) >= kMostSets * static_cast<double>(completed);
  const bool in_order = last->nodelet.empty() || sent_by_one(callbacks);
  const bool one = (found || (mostly && in_order)) && !keeps_for_another(*last);
  for (const ObservedCallback* const callback : callbacks) {
    if (!one) any_completes_.insert(callback);
    if (!one || callback == last) set_publishes_[callback][topic] = completed;
    if (one && callback != last && publishing_runs(*callback) == published(callback) && !completes_sets(*callback)) {
      completed_by_.emplace(callback, last);
    }
  }
}

// Light subscriptions of the same nodelet that publish nothing and are called by turns with one of these: it keeps what
// they get until its own message completes the set. One that gets what these send, by way of others too, is no part of
// it. Those that cannot be told apart keep as others do.
InferredGraph::Callbacks InferredGraph::keepers_beside(const Callbacks& publishing) const {
  Callbacks keepers;
  for (const ObservedCallback& callback : callbacks_) {
    const bool may_keep = callback.kind == Binding::Kind::kTopic && !callback.nodelet.empty() &&
                          !callback.runs.empty() && is_light(callback);
    if (!may_keep || !of_one_program(callback, *publishing.front())) continue;
    const bool beside = std::any_of(publishing.begin(), publishing.end(),
                                    [&](const ObservedCallback* other) { return by_turns(callback, *other); });
    if (!beside) continue;
    const std::set<const ObservedCallback*> before = senders_before(callback);
    const bool is_behind_them = std::any_of(publishing.begin(), publishing.end(),
                                            [&](const ObservedCallback* other) { return before.count(other) > 0; });
    if (!is_behind_them) keepers.push_back(&callback);
  }
  return keepers;
}

// All that they get: then it comes in the order in which that one sends it.
bool InferredGraph::sent_by_one(const Callbacks& callbacks) const {
  const Callbacks senders = senders_to(*callbacks.front());
  if (senders.size() != 1) return false;
  const std::string& sender = senders.front()->ros_node;
  return std::all_of(callbacks.begin(), callbacks.end(), [&](const ObservedCallback* one) {
    return senders_to(*one) == senders && std::all_of(one->runs.begin(), one->runs.end(), [&](const ObservedRun& run) {
             return run.from.empty() || run.from == sender;
           });
  });
}

bool InferredGraph::sends(const ObservedCallback& callback) const {
  return publishes(callback) || set_publishes_.count(&callback) > 0;
}

// What it publishes itself, or might have for its set.
std::size_t InferredGraph::count_sent(const ObservedCallback& callback, const std::string& topic) const {
  const std::size_t own = count_published(callback, topic);
  const auto sets = set_publishes_.find(&callback);
  if (sets == set_publishes_.end()) return own;
  const auto known = sets->second.find(topic);
  return known == sets->second.end() ? own : std::max(own, known->second);
}

std::set<std::string> InferredGraph::sent_topics(const ObservedCallback& callback) const {
  std::set<std::string> topics;
  for (const ObservedRun& run : callback.runs) topics.insert(run.published.begin(), run.published.end());
  const auto sets = set_publishes_.find(&callback);
  if (sets == set_publishes_.end()) return topics;
  for (const auto& [topic, count] : sets->second) topics.insert(topic);
  return topics;
}

// All whose messages reach it, by way of others too.
std::set<const ObservedCallback*> InferredGraph::senders_before(const ObservedCallback& callback) const {
  std::set<const ObservedCallback*> found;
  Callbacks readers{&callback};
  while (!readers.empty()) {
    const ObservedCallback& reader = *readers.back();
    readers.pop_back();
    for (const ObservedCallback* const sender : senders_to(reader)) {
      if (found.insert(sender).second) readers.push_back(sender);
    }
  }
  return found;
}

InferredGraph::Callbacks InferredGraph::senders_to(const ObservedCallback& callback) const {
  const auto senders = publishing_.find(callback.name);
  const bool none = callback.kind != Binding::Kind::kTopic || senders == publishing_.end();
  return none ? Callbacks() : senders->second;
}

// Whoever sends to the other sends to this one as well, by way of more callbacks.
bool InferredGraph::is_behind(const ObservedCallback& callback, const ObservedCallback& other) const {
  const std::set<const ObservedCallback*> before = senders_before(callback);
  const Callbacks senders = senders_to(other);
  return before.size() > senders_before(other).size() &&
         std::all_of(senders.begin(), senders.end(),
                     [&](const ObservedCallback* sender) { return before.count(sender) > 0; });
}

bool InferredGraph::keeps_for_another(const ObservedCallback& callback) const {
  return completed_by_.count(&callback) > 0;
}

bool InferredGraph::completes_sets(const ObservedCallback& callback) const {
  return std::any_of(completed_by_.begin(), completed_by_.end(),
                     [&](const auto& each) { return each.second == &callback; });
}

// Of the candidates, without those that only keep messages.
void InferredGraph::find_nodes() {
  for (const ObservedCallback* const callback : candidates_) {
    const bool has_publisher = std::any_of(candidates_.begin(), candidates_.end(), [&](const ObservedCallback* other) {
      return of_one_program(*other, *callback) && sends(*other);
    });
    if (is_light(*callback) && callback->kind == Binding::Kind::kTimer) {
      remarks_.push_back(described(*callback) + " publishes nothing and takes next to no time: it is left as it is");
      continue;
    }
    if (keeps_for_another(*callback)) {
      remarks_.push_back(described(*callback) + " is left as it is: its messages are used with those of " +
                         completed_by_[callback]->name + ", which come last");
      continue;
    }
    if (is_light(*callback) && has_publisher && !sends(*callback)) continue;
    vertex_of_[callback] = vertices_.size();
    Vertex& vertex = vertices_.emplace_back();
    vertex.callback = callback;
    vertex.takes_all = any_completes_.count(callback) > 0;
    if (vertex.takes_all) vertex.set = set_publishes_[callback].begin()->first;
    vertex.period = callback->kind == Binding::Kind::kTimer ? callback->period : median_interval(*callback);
  }
}

void InferredGraph::find_edges() {
  for (const ObservedCallback* const candidate : candidates_) {
    const ObservedCallback& callback = *candidate;
    if (callback.kind != Binding::Kind::kTopic) continue;
    const auto own = vertex_of_.find(&callback);
    if (own == vertex_of_.end()) {
      add_edges_to(callback, users_of(callback), true);
      continue;
    }
    add_edges_to(callback, {own->second}, false);
    if (sends(callback)) continue;
    for (const std::size_t sibling : publishing_siblings(callback)) {
      add_edge(own->second, sibling, "within " + program_of(callback), true, callback.runs.size());
    }
  }
  add_edges_out();
}

// Who uses what the callback keeps.
InferredGraph::Indices InferredGraph::users_of(const ObservedCallback& callback) const {
  const auto completed = completed_by_.find(&callback);
  const auto user = completed == completed_by_.end() ? vertex_of_.end() : vertex_of_.find(completed->second);
  return user == vertex_of_.end() ? publishing_siblings(callback) : Indices{user->second};
}

// Timers of its program, else its other callbacks that publish. Where a program sends to itself, as one of nodelets
// does that are not told apart, what its messages go back to does not use them.
InferredGraph::Indices InferredGraph::publishing_siblings(const ObservedCallback& callback) const {
  const Callbacks senders = senders_to(callback);
  const bool sends_to_itself = std::any_of(senders.begin(), senders.end(), [&](const ObservedCallback* sender) {
    return of_one_program(*sender, callback);
  });
  const std::set<const ObservedCallback*> before =
      sends_to_itself ? senders_before(callback) : std::set<const ObservedCallback*>{};
  Indices timers;
  Indices all;
  for (const auto& [other, vertex] : vertex_of_) {
    if (other == &callback || !of_one_program(*other, callback)) continue;
    if (!sends(*other)) continue;
    if (before.count(other) > 0) continue;
    all.push_back(vertex);
    if (other->kind == Binding::Kind::kTimer) timers.push_back(vertex);
  }
  Indices& found = timers.empty() ? all : timers;
  std::sort(found.begin(), found.end());
  return found;
}

void InferredGraph::add_edge(std::size_t from, std::size_t to, const std::string& topic, bool kept, std::size_t count) {
  if (from == to) return;
  const auto known =
      std::find_if(found_.begin(), found_.end(), [&](const Edge& edge) { return edge.from == from && edge.to == to; });
  if (known == found_.end()) {
    found_.push_back({from, to, topic, kept, count});
  } else if (known->kept && !kept) {
    *known = {from, to, topic, kept, count};
  }
}

std::size_t InferredGraph::external(const std::string& topic, bool begins) {
  for (std::size_t index = 0; index < vertices_.size(); ++index) {
    if (vertices_[index].topic == topic) return index;
  }
  Vertex& vertex = vertices_.emplace_back();
  vertex.topic = topic;
  const auto& nodes = begins ? connections_.publishers : connections_.subscribers;
  if (const auto known = nodes.find(topic); known != nodes.end()) vertex.ros_nodes = known->second;
  return vertices_.size() - 1;
}

// From whoever sends what `reader` was called with, to those that use it.
void InferredGraph::add_edges_to(const ObservedCallback& reader, const Indices& targets, bool kept) {
  std::set<std::string> sent_by_nodes;
  for (const auto& [sender, vertex] : vertex_of_) {
    const std::size_t count = count_sent(*sender, reader.name);
    if (count == 0) continue;
    sent_by_nodes.insert(sender->ros_node);
    for (const std::size_t target : targets) add_edge(vertex, target, reader.name, kept, count);
  }
  std::vector<nanoseconds> from_others;
  std::vector<std::string> others;
  for (const ObservedRun& run : reader.runs) {
    if (sent_by_nodes.count(run.from) > 0 || (run.from.empty() && !sent_by_nodes.empty())) continue;
    from_others.push_back(run.begin);
    if (!run.from.empty() && !contains(others, run.from)) others.push_back(run.from);
  }
  if (from_others.empty() || targets.empty()) return;
  const std::size_t source = external(reader.name, true);
  Vertex& vertex = vertices_[source];
  for (std::string& other : others) {
    if (!contains(vertex.ros_nodes, other)) vertex.ros_nodes.push_back(std::move(other));
  }
  if (!vertex.period) vertex.period = clock_of(from_others);
  for (const std::size_t target : targets) add_edge(source, target, reader.name, kept, from_others.size());
}

// To those that are not observed and take what no observed callback takes.
void InferredGraph::add_edges_out() {
  for (std::size_t from = 0, count = vertices_.size(); from < count; ++from) {
    if (vertices_[from].external()) continue;
    for (const std::string& topic : sent_topics(*vertices_[from].callback)) {
      const bool is_read = std::any_of(callbacks_.begin(), callbacks_.end(), [&](const ObservedCallback& callback) {
        return callback.kind == Binding::Kind::kTopic && callback.name == topic;
      });
      const auto readers = connections_.subscribers.find(topic);
      if (is_read || readers == connections_.subscribers.end() || readers->second.empty()) continue;
      add_edge(from, external(topic, false), topic, false, count_sent(*vertices_[from].callback, topic));
    }
  }
}

bool InferredGraph::reaches(std::size_t from, std::size_t to) const {
  if (from == to) return true;
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return edge.from == from && reaches(edge.to, to); });
}

// The surest first: messages that were published and taken, of these the most frequent.
void InferredGraph::take_edges() {
  std::stable_sort(found_.begin(), found_.end(), [this](const Edge& a, const Edge& b) {
    if (a.kept != b.kept) return b.kept;
    if (a.count != b.count) return a.count > b.count;
    return std::pair(vertices_[a.from].name, vertices_[a.to].name) <
           std::pair(vertices_[b.from].name, vertices_[b.to].name);
  });
  for (const Edge& edge : found_) {
    if (!reaches(edge.to, edge.from)) {
      edges_.push_back(edge);
      continue;
    }
    remarks_.push_back("the edge " + vertices_[edge.from].name + " -> " + vertices_[edge.to].name + " (" + edge.topic +
                       ") is left out: it would close a cycle");
  }
}

// Of the nodelet or ROS node, without its namespace unless another has the same name, with the callback where there are
// several; or of the topic.
void InferredGraph::name_vertices() {
  std::map<std::string, int> of_program;
  for (const Vertex& vertex : vertices_) {
    if (!vertex.external()) ++of_program[program_of(*vertex.callback)];
  }
  std::map<std::string, int> of_last_part;
  for (const auto& [program, vertices] : of_program) ++of_last_part[last_part(program)];
  std::set<std::string> taken;
  for (Vertex& vertex : vertices_) {
    std::string name = vertex.external() ? vertex.topic.substr(1) : last_part(program_of(*vertex.callback));
    if (!vertex.external() && of_last_part[name] > 1) name = program_of(*vertex.callback).substr(1);
    if (!vertex.external() && of_program[program_of(*vertex.callback)] > 1) {
      name += vertex.callback->kind == Binding::Kind::kTimer ? ".timer_" + exact_text(vertex.callback->period)
                                                             : "." + last_part(vertex.callback->name);
    }
    if (name.size() > kMaxName) name = name.substr(name.size() - kMaxName);
    std::string unique = name;
    for (int number = 2; !taken.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
    vertex.name = unique;
  }
}

// Each after all that it takes from; else as they were found.
void InferredGraph::sort_vertices() {
  std::vector<bool> placed(vertices_.size(), false);
  while (order_.size() < vertices_.size()) {
    for (std::size_t vertex = 0; vertex < vertices_.size(); ++vertex) {
      const bool waits = placed[vertex] || std::any_of(edges_.begin(), edges_.end(), [&](const Edge& edge) {
                           return edge.to == vertex && !placed[edge.from];
                         });
      if (waits) continue;
      placed[vertex] = true;
      order_.push_back(vertex);
    }
  }
}

// Of callbacks, from their senders on.
void InferredGraph::bound_rates() {
  std::vector<double> rates(vertices_.size(), 0.0);  // Hz, at most; 0: not known
  for (const std::size_t index : order_) {
    Vertex& vertex = vertices_[index];
    if (vertex.external() || vertex.callback->kind == Binding::Kind::kTimer) {
      if (vertex.period) rates[index] = 1.0 / seconds_of(*vertex.period);
      continue;
    }
    double rate = 0.0;
    std::map<std::string, double> of_sets;  // of callbacks of which one completes each
    bool known = true;
    for (const Edge& edge : edges_) {
      if (edge.to != index || edge.kept) continue;
      known = known && rates[edge.from] > 0.0;
      const std::string& set = vertices_[edge.from].set;
      if (set.empty()) {
        rate += rates[edge.from];
      } else {
        of_sets[set] = std::max(of_sets[set], rates[edge.from]);
      }
    }
    for (const auto& [set, most] : of_sets) rate += most;
    if (!known || rate <= 0.0) continue;
    rates[index] = rate;
    vertex.min_period = nanoseconds(static_cast<nanoseconds::rep>(1e9 / (kCatchesUp * rate)));
  }
}

}  // namespace catan_ros
