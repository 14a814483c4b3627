// A real roscore for tests, on a port of its own, with a home of its own; ended on every path, also where the test is
// killed.
//
// Thread safety: one thread.
#pragma once

#include <string>

namespace catan_ros {

class Roscore {
 public:
  // In `folder`, which holds its logs and is the home of this process from now on: HOME, ROS_HOME, ROS_MASTER_URI and
  // ROS_HOSTNAME are set for it and what it starts. Throws where it does not answer in time.
  explicit Roscore(const std::string& folder);
  ~Roscore();
  Roscore(const Roscore&) = delete;
  Roscore& operator=(const Roscore&) = delete;

  void stop();
  // Once more, on the same port. Throws where it does not answer in time.
  void start();

 private:
  const std::string folder_;
  const int port_;
  int process_ = 0;
};

}  // namespace catan_ros
