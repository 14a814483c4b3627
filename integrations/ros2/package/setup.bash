# Adds the package catan_ros2 to ROS's path: source it.
_catan_ros2="$(cd "$(dirname "${BASH_SOURCE[0]}")/prefix" && pwd)"
export AMENT_PREFIX_PATH="$_catan_ros2:$AMENT_PREFIX_PATH"
export CMAKE_PREFIX_PATH="$_catan_ros2:$CMAKE_PREFIX_PATH"
export LD_LIBRARY_PATH="$_catan_ros2/lib:$LD_LIBRARY_PATH"
unset _catan_ros2
