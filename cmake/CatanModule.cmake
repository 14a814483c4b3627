# catan_module(NAME DEPENDS module... LIBRARIES target... TEST_LIBRARIES target...)
#
# One library target a module: catan_NAME, from all sources of the current folder and those below it. Files that end in
# _test.cpp become one test program, NAME_test. DEPENDS is the module's row of the table in docs/architecture.md: what it
# may include and link; tests/architecture checks that the sources keep to it. Installed, the library is catan::NAME.
function(catan_module name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LIBRARIES;TEST_LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp *.h)
  set(tests ${sources})
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")

  list(TRANSFORM ARG_DEPENDS PREPEND catan_ OUTPUT_VARIABLE targets)
  add_library(catan_${name} STATIC ${sources})
  target_include_directories(catan_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:include>)
  target_link_libraries(catan_${name} PUBLIC ${targets} PRIVATE ${ARG_LIBRARIES})
  set_target_properties(catan_${name} PROPERTIES EXPORT_NAME ${name})
  if(name MATCHES "^(model|plan|planner|dispatch|policy|driver|sim)$")
    # What is planned and simulated must be the same on machines whose processors can fuse a multiplication with an addition.
    target_compile_options(catan_${name} PRIVATE -ffp-contract=off)
    # Where simulations spend their time. At -O3 GCC 12 takes strings in aggregates that are all set for uninitialised:
    # other builds still have that warning.
    if(name MATCHES "^(model|planner|dispatch|sim)$" AND NOT CATAN_SANITIZE AND NOT CATAN_FUZZ)
      target_compile_options(catan_${name} PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:-O3>
                             $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    endif()
  endif()
  install(TARGETS catan_${name} EXPORT catan)
  set_property(GLOBAL APPEND PROPERTY CATAN_MODULES "${name}:${ARG_DEPENDS}")

  if(BUILD_TESTING AND tests)
    catan_test(${name}_test SOURCES ${tests} LIBRARIES catan_${name} ${ARG_LIBRARIES} ${ARG_TEST_LIBRARIES})
  endif()
endfunction()

# catan_test(NAME [SERIAL] SOURCES file... LIBRARIES target...): a GoogleTest program, each of its tests known to CTest.
# SERIAL: its tests load CPUs in real time, so nothing else may run beside them.
function(catan_test name)
  cmake_parse_arguments(ARG "SERIAL" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} SYSTEM PRIVATE ${rapidcheck_INCLUDE_DIRS})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gmock GTest::gtest_main rapidcheck)
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300 RUN_SERIAL ${ARG_SERIAL})
endfunction()

# Writes "module: its dependencies" lines for the architecture test.
function(catan_write_module_table)
  get_property(modules GLOBAL PROPERTY CATAN_MODULES)
  set(text "")
  foreach(module IN LISTS modules)
    if(module MATCHES "^[a-z]+:")
      string(APPEND text "\n${module}")
    else()
      string(APPEND text " ${module}")
    endif()
  endforeach()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/modules.txt CONTENT "${text}\n" @ONLY)
endfunction()
