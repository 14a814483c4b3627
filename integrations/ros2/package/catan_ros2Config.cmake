# find_package(catan_ros2): link catan_ros2::catan_ros2, and include <catan_ros2/executor.hpp>.
include(CMakeFindDependencyMacro)
find_dependency(rclcpp)
if(NOT TARGET catan_ros2::catan_ros2)
  get_filename_component(catan_ros2_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
  add_library(catan_ros2::catan_ros2 SHARED IMPORTED)
  set_target_properties(catan_ros2::catan_ros2 PROPERTIES
    IMPORTED_LOCATION "${catan_ros2_prefix}/lib/libcatan_ros2.so"
    INTERFACE_INCLUDE_DIRECTORIES "${catan_ros2_prefix}/include/catan_ros2"
    INTERFACE_LINK_LIBRARIES rclcpp::rclcpp)
endif()
