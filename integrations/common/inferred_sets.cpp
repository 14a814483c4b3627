// Of the inferred graph: messages that are used together, as by a synchronizer of message_filters.
#include <algorithm>
#include <array>
#include <set>

#include "common/inferred_graph.h"
#include "common/observed_figures.h"

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;

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

std::size_t publishing_runs(const ObservedCallback& callback) {
  return static_cast<std::size_t>(std::count_if(callback.runs.begin(), callback.runs.end(),
                                                [](const ObservedRun& run) { return !run.published.empty(); }));
}

}  // namespace

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

}  // namespace catan_ros
