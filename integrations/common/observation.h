// What callbacks of ROS programs were seen to do: what `catan ros bind` makes an app file of (inferred_app.h).
//
// Each program that is observed appends to a file of its own, a line at a time, in one system call: so what is there is
// whole however the program ends. The command reads all files of the folder.
//
//   node<tab>/detector                                          whose file it is
//   callback<tab>0<tab>topic<tab>/images<tab>sensor_msgs/Image   its callbacks, as they come to be; of a timer the
//                                                               period in ns in place of the name; of a nodelet's
//                                                               two more fields, its name and how its queue calls
//                                                               callbacks: `single`, one at a time, or `multi`
//   run<tab>0<tab>71<tab>52000<tab>1200<tab>/camera<tab>/things  thread, begin on the monotonic clock, CPU time of the
//                                                               thread (both in ns), who sent the message, the topics
//                                                               that it published on, separated by commas
//
// Empty fields are "-".
//
// Thread safety: ObservationLog from any thread; the rest are pure functions and plain values.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/binding.h"

namespace catan_ros {

// The folder in which programs are to write what is observed of them; not set: they are not observed.
inline constexpr const char* kObserveVariable = "CATAN_ROS_OBSERVE";

struct ObservedRun {
  std::int64_t thread = 0;
  std::chrono::nanoseconds begin{0};
  std::chrono::nanoseconds cpu_time{0};
  std::string from{};                    // the ROS node that sent the message; empty: not known, or no message
  std::vector<std::string> published{};  // topics, each once

  friend bool operator==(const ObservedRun&, const ObservedRun&) = default;
};

struct ObservedCallback {
  std::string ros_node{};
  Binding::Kind kind = Binding::Kind::kTopic;
  std::string name{};                  // of a topic or service
  std::chrono::nanoseconds period{0};  // of a timer
  std::string type{};                  // of the messages
  std::string nodelet{};               // of the ROS node; empty: of none that is known
  bool one_at_a_time = false;          // so the nodelet's queue calls it and its like
  std::vector<ObservedRun> runs{};

  friend bool operator==(const ObservedCallback&, const ObservedCallback&) = default;
};

// Of one nodelet, or of one ROS node where of none: what is in the memory of the one is in that of the other.
bool of_one_program(const ObservedCallback& a, const ObservedCallback& b);
// The name of that program.
const std::string& program_of(const ObservedCallback& callback);

class ObservationLog {
 public:
  // Of this process, a ROS node of that name. Null: the folder is not there, or full.
  static std::unique_ptr<ObservationLog> open(const std::string& folder, const std::string& ros_node);
  ~ObservationLog();
  ObservationLog(const ObservationLog&) = delete;
  ObservationLog& operator=(const ObservationLog&) = delete;

  // Its number, for add_run(). Of `callback`, ros_node and runs are not written.
  std::size_t add(const ObservedCallback& callback);
  void add_run(std::size_t callback, const ObservedRun& run);

 private:
  explicit ObservationLog(int file) : file_(file) {}
  void write(const std::string& line) const;

  int file_;
  std::atomic<std::size_t> count_{0};
};

// Of one file. What is not understood is left out: the last line may be torn.
std::vector<ObservedCallback> parse_observations(std::string_view text);
// Of all files of a folder, in the order of the ROS nodes' names.
std::vector<ObservedCallback> read_observations(const std::string& folder);

}  // namespace catan_ros
