# For a build of ILLIXR, whose sources stay as they are:
#
#   cmake -S ILLIXR -B build -DCMAKE_PROJECT_ILLIXR_INCLUDE=CATAN/integrations/illixr/illixr_plugins.cmake ...
#
# has all of its plugins compiled behind plugin_hooks.h; -DCATAN_ILLIXR_PLUGINS="offline_imu;rk4_integrator" these alone.
# The runtime and its services' interfaces stay as they are.
get_filename_component(CATAN_INTEGRATIONS ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)

function(catan_hook_plugins folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    if(NOT target MATCHES "^plugin\\.([^.]+)" OR CMAKE_MATCH_1 STREQUAL "main")
      continue()
    endif()
    if(CATAN_ILLIXR_PLUGINS AND NOT CMAKE_MATCH_1 IN_LIST CATAN_ILLIXR_PLUGINS)
      continue()
    endif()
    target_include_directories(${target} PRIVATE ${CATAN_INTEGRATIONS})
    target_compile_options(${target} PRIVATE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-include illixr/plugin_hooks.h>")
    message(STATUS "catan: ${target} is compiled behind plugin_hooks.h")
  endforeach()
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(subfolder IN LISTS folders)
    catan_hook_plugins(${subfolder})
  endforeach()
endfunction()

cmake_language(DEFER DIRECTORY ${CMAKE_SOURCE_DIR} CALL catan_hook_plugins ${CMAKE_SOURCE_DIR})
