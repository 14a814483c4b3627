// catan ros node: the app as a node of ROS.
#pragma once

namespace CLI {
class App;
}

namespace ctn::tool {

void add_ros_node_command(CLI::App& ros, int& exit_code);

}  // namespace ctn::tool
