// navigation_node NAME: one of the robot's nodes (robot_nodes.h) as a program of ROS.
#include <ros/init.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "ros1/navigation/robot_nodes.h"

int main(int count, char** arguments) {
  using namespace ctn::navigation::ros1;
  std::vector<std::string> words;
  ros::removeROSArgs(count, arguments, words);
  const std::vector<std::string> names = robot_node_names();
  const std::string name = words.size() == 2 ? words[1] : "";
  bool known = false;
  for (const std::string& one : names) known = known || one == name;
  if (!known) {
    std::fprintf(stderr, "navigation_node: give one of these nodes:");
    for (const std::string& one : names) std::fprintf(stderr, " %s", one.c_str());
    std::fprintf(stderr, "\n");
    return 2;
  }
  ros::init(count, arguments, name);
  const ros::NodeHandle begins;  // ROS, as long as it lives
  const std::unique_ptr<RobotNode> node = make_robot_node(name);
  if (!node) return 2;
  ros::spin();
  return 0;
}
