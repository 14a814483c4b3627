// catan ros bind: from programs that run to a first app file.
#pragma once

namespace CLI {
class App;
}

namespace ctn::tool {

void add_ros_bind_command(CLI::App& ros, int& exit_code);

}  // namespace ctn::tool
