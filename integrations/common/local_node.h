// A node in a program whose nodes share messages as they are: what its run under way sends and takes, by where messages
// lie (message_runs.h). What a run without output has taken, the node keeps for those that come: of each predecessor
// the newest counts as an input of the next run that gives output, if that takes nothing of it itself. (A filter takes
// an image, and uses it when there is IMU data that is newer.)
//
// Thread safety: binding() and current() from any thread; the rest by the thread that is in a run of the node.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "common/binding.h"
#include "common/message_runs.h"
#include "common/node_runs.h"

namespace catan_ros {

class LocalNode {
 public:
  // `message_runs` is of the whole program, and outlives it.
  LocalNode(Binding binding, MessageRuns& message_runs) : binding_(std::move(binding)), message_runs_(&message_runs) {}
  virtual ~LocalNode() = default;
  LocalNode(const LocalNode&) = delete;
  LocalNode& operator=(const LocalNode&) = delete;

  const Binding& binding() const { return binding_; }
  // The one whose run the calling thread is in; null: none.
  static LocalNode* current();

  // The run is about to send such a message; has sent one on that topic, which may end it; handles or has read one.
  void note_sent(MessageRuns::Key key);
  virtual void note_published(const std::string& topic) = 0;
  void note_taken(MessageRuns::Key key);

 protected:
  // Of one whose messages are not known by keys: what they were sent by is noted by note_taken_from().
  explicit LocalNode(Binding binding) : binding_(std::move(binding)) {}

  // The run under way has taken an output of that run of `predecessor`.
  void note_taken_from(const std::string& predecessor, std::uint64_t run);
  void begin(Runs& runs);
  void end(bool output);
  bool in_run() const { return runs_ != nullptr; }

 private:
  const Binding binding_;
  MessageRuns* const message_runs_ = nullptr;
  Runs* runs_ = nullptr;                       // while the calling thread is in a run
  std::map<std::string, std::uint64_t> kept_;  // runs, by predecessors
};

}  // namespace catan_ros
