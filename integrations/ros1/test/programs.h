// For tests with ROS programs in processes of their own: a master, a folder, programs that are started there and ended
// on every path, and what they count.
//
// Thread safety: one thread.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "ros1/test/roscore.h"

namespace catan_ros {

std::string text_of(const std::string& path);

class ProgramsTest : public testing::Test {
 protected:
  using Milliseconds = std::chrono::milliseconds;
  using Json = nlohmann::json;

  ProgramsTest();
  ~ProgramsTest() override;

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  // A shell's command, in the folder; what it prints goes to NAME.out and NAME.err.
  int start(const std::string& name, const std::string& command);
  int start_node(const std::string& name, const std::string& arguments);
  // By the folder's app and bindings.
  int start_under_catan(const std::string& arguments);

  int end(int process, int signal);
  // Exit code, 128 + signal; 255: it did not end.
  int wait(int process, Milliseconds timeout);

  long counted(const std::string& node, const std::string& what) const;
  // Until it has counted so many more.
  bool counts(const std::string& node, const std::string& what, long more,
              Milliseconds within = std::chrono::seconds{20}) const;

  // app.yaml: an app of one node, `work`, with these keys; `more`: lines that follow.
  void write_app_of_work(const std::string& keys, const std::string& more = "") const;
  // That node is what the ROS node does with a message on /data.
  void write_binding_of_work(const std::string& ros_node, const std::string& file = "bind.yaml",
                             const std::string& callback = "topic: /data") const;
  // app.yaml: the nodelets program's camera, with these keys, and the two behind it, with those. bind.yaml has their
  // callbacks.
  void write_app_of_nodelets(const std::string& camera, const std::string& others = "") const;

  // launch.sh, of these commands.
  void write_script(const std::string& text) const;
  // launch.sh starts these nodes, and waits for them: what a launch file does.
  void write_launcher(const std::vector<std::string>& lines) const;

  // talker.py, for /usr/bin/python3: a node that publishes ones on a topic, 20 times a second. It makes the file
  // `talks` when it begins.
  void write_talker(const std::string& topic, const std::string& type) const;

  Roscore& roscore() { return *roscore_; }

  static Json node(const Json& report, const std::string& name);

 private:
  std::string folder_;
  std::unique_ptr<Roscore> roscore_;
  std::vector<int> processes_;
};

}  // namespace catan_ros
