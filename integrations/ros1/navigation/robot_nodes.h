// The nodes of the navigation app (apps/navigation/nodes) as nodes of ROS: each subscribes what it takes, and publishes
// what it gives. They are plain roscpp, and know nothing of Catan.
//
//   node             takes                        gives
//   laser_driver     /device/scan, /device/odom   /laser           scan and odometry of one instant
//   odometry_driver  /device/odom                 /odom            nav_msgs/Odometry
//   scan_filter      /laser                       /scan
//   local_mapper     /scan, /odom                 /local_map
//   local_planner    /local_map, /command         /cmd_vel         geometry_msgs/TwistStamped, of the map's scan
//   localizer        /scan, each                  /localization, and /keyframes when there are new ones
//   global_mapper    /keyframes                   /map
//   global_planner   /localization, /map          /path
//   commander        /localization, /path         /command, /pose  geometry_msgs/PoseStamped, of the odometry
//
// A node works in the callback of the first topic that it takes, and keeps what came last on the other. With the
// parameter ~rate it keeps that, too, and works in a timer of that rate, in Hz: rates that are set by hand. The global
// planner finds its goal in the world's file of ~world.
//
// Thread safety: one spinner.
#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <string>
#include <vector>

namespace ctn::navigation::ros1 {

class RobotNode {
 public:
  virtual ~RobotNode() = default;
};

std::vector<std::string> robot_node_names();
// Null: there is no such node, or its parameters are wrong, as ROS's log says.
std::unique_ptr<RobotNode> make_robot_node(const std::string& name);

}  // namespace ctn::navigation::ros1
