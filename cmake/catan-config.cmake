# find_package(catan): the target catan::catan, which is what include/catan needs. Its libraries are static, so their own
# dependencies must be found too.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(fmt)
find_dependency(nlohmann_json)
find_dependency(yaml-cpp)
find_dependency(SQLite3)
find_dependency(Eigen3)
include(${CMAKE_CURRENT_LIST_DIR}/catan-targets.cmake)
if(NOT TARGET catan::catan)
  add_library(catan::catan INTERFACE IMPORTED)
  target_link_libraries(catan::catan INTERFACE catan::runtime)
endif()
