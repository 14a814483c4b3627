// Which callback is which node, as the command tells it to programs: text in an environment variable, a line a node.
// People write it in YAML (docs/ros1.md, docs/illixr.md), which the command checks against the app.
//
//   GL<tab>/localiser<tab>-<tab>topic<tab>/scan<tab>queue<tab>scan<tab>/pose,/map<tab>GP,NC
//
// are node, program (ROS: the ROS node; ILLIXR: the plugin), nodelet of it (none: any), kind, name (of a timer: its
// period in ns; of a loop: nothing), what is said of the node (queue, itself, world, within, behind, separated by
// commas), its predecessors, the topics that its successors are bound to (none: any counts), and its successors. Empty
// fields are
// "-".
//
// Thread safety: pure functions, plain values.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace catan_ros {

inline constexpr const char* kBindingsVariable = "CATAN_ROS_BINDINGS";
inline constexpr const char* kIllixrBindingsVariable = "CATAN_ILLIXR_BINDINGS";
// The file of message_runs.h; not set: none.
inline constexpr const char* kMessageRunsVariable = "CATAN_ROS_MESSAGES";
// That of run_times.h.
inline constexpr const char* kRunTimesVariable = "CATAN_ROS_RUN_TIMES";

struct Binding {
  enum class Kind { kTopic, kTimer, kService, kLoop };

  std::string node{};
  std::string ros_node{};  // or plugin
  std::string nodelet{};   // of the ROS node; empty: the first callback of that name, whosever it is
  Kind kind = Kind::kTopic;
  std::string name{};                        // of a topic or service; of a loop empty
  std::chrono::nanoseconds period{0};        // of a timer
  bool takes_all = false;                    // input: queue
  bool runs_by_itself = false;               // an unscheduled node with a period
  bool always_gives_output = false;          // nothing of the app comes after it
  bool feeds_own_program = false;            // what comes after it is of the same ROS node
  bool is_behind = false;                    // in its subchain: a run of the one before it triggers it
  std::vector<std::string> predecessors{};   // nodes that its messages may come from
  std::vector<std::string> output_topics{};  // of its successors; empty: what it publishes anywhere is its output
  std::vector<std::string> successors{};     // nodes of programs, which may take its data by other topics as well

  friend bool operator==(const Binding&, const Binding&) = default;

  bool gives_output_on(std::string_view topic) const;
  // Whoever asks a service waits for the answer: so a run answers all that have asked, and that is its output.
  bool handles_all() const { return takes_all || kind == Kind::kService; }
  bool gives_output_unseen() const { return always_gives_output || kind == Kind::kService; }
};

std::string to_text(const std::vector<Binding>& bindings);
// None: it is not what to_text() writes.
std::optional<std::vector<Binding>> parse_bindings(std::string_view text);

// Those of one ROS node.
std::vector<Binding> bindings_of(const std::vector<Binding>& bindings, std::string_view ros_node);
// Of a callback of that nodelet (empty: of none): the binding that names the nodelet, else one that names none. Null:
// there is none.
const Binding* find_named(const std::vector<Binding>& bindings, Binding::Kind kind, std::string_view name,
                          std::string_view nodelet);
// Whether who names that period means a timer of the other: to 0.1 %, since 1.0 / 30 s has no end.
bool is_same_period(std::chrono::nanoseconds named, std::chrono::nanoseconds asked_for);
// What `find(fits)` points to, which it takes of those whose named period `fits`: exactly; else, where that is null, to
// 0.1 %.
template <class Find>
auto find_by_period(std::chrono::nanoseconds asked_for, const Find& find) {
  const auto exact = find([&](std::chrono::nanoseconds named) { return named == asked_for; });
  return exact != nullptr ? exact
                          : find([&](std::chrono::nanoseconds named) { return is_same_period(named, asked_for); });
}
const Binding* find_timer(const std::vector<Binding>& bindings, std::chrono::nanoseconds period,
                          std::string_view nodelet);

}  // namespace catan_ros
