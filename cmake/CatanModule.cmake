# catan_module(NAME DEPENDS module... LIBRARIES target... TEST_LIBRARIES target... REALTIME test... UNSANITIZED test...)
#
# One library target a module: catan_NAME, from all sources of the current folder and those below it. Files that end in
# _test.cpp become one test program, NAME_test. DEPENDS is the module's row of the table in docs/architecture.md: what it
# may include and link; tests/architecture checks that the sources keep to it. Installed, the library is catan::NAME.
#
# With CATAN_UNITY all of them are compiled as one (docs/decisions/0035-a-module-is-one-source.md), so helpers of two files need
# names that differ.
#
# REALTIME names tests, as GoogleTest's filters do, that run threads against the clock, UNSANITIZED those that sanitizers would
# find nothing in: see catan_test.
function(catan_module name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;LIBRARIES;TEST_LIBRARIES;REALTIME;UNSANITIZED" ${ARGN})
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
  # The headers need it, also in projects that say nothing of a standard.
  target_compile_features(catan_${name} PUBLIC cxx_std_20)
  target_link_libraries(catan_${name} PUBLIC ${targets} PRIVATE ${ARG_LIBRARIES})
  set_target_properties(catan_${name} PROPERTIES EXPORT_NAME ${name})
  catan_unity(catan_${name})
  if(name MATCHES "^(model|plan|trial|planner|paper|dispatch|policy|driver|sim|baselines)$")
    # What is planned and simulated must be the same on machines whose processors can fuse a multiplication with an addition.
    target_compile_options(catan_${name} PRIVATE -ffp-contract=off)
    # Where simulations spend their time, under sanitizers as well. At -O3 GCC 12 takes strings in aggregates that are all set
    # for uninitialised: other builds still have that warning.
    if(name MATCHES "^(model|trial|planner|paper|dispatch|driver|sim|baselines)$")
      set(fast -O3)
      if(CATAN_SANITIZE)
        set(fast -O2)
      endif()
      target_compile_options(catan_${name} PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:${fast}>
                             $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    endif()
  endif()
  if(name MATCHES "^(config|report|page|export|view|why|doctor|web)$" OR
     (CATAN_SANITIZE AND name MATCHES "^(record|api|capi)$"))
    catan_compile_quickly(catan_${name})
  endif()
  # Those whose inputs the fuzzers vary. It takes time, which those that compute have not got.
  if(CATAN_FUZZ AND name MATCHES "^(base|graph|config|plan|os|record|flight|report|page|runtime|web)$")
    target_compile_options(catan_${name} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
  install(TARGETS catan_${name} EXPORT catan)
  set_property(GLOBAL APPEND PROPERTY CATAN_MODULES "${name}:${ARG_DEPENDS}")

  if(BUILD_TESTING AND tests)
    catan_test(${name}_test SOURCES ${tests} REALTIME ${ARG_REALTIME}
               UNSANITIZED ${ARG_UNSANITIZED} LIBRARIES catan_${name} ${ARG_LIBRARIES} ${ARG_TEST_LIBRARIES})
  endif()
endfunction()

# catan_compile_quickly(TARGET): what does not take long to run is optimised little, and not at all for the address sanitizer,
# where that is half of the time that it takes to compile. (With the fake system and the runtime among them tests take twice as
# long.)
function(catan_compile_quickly target)
  if(CATAN_SANITIZE MATCHES "address")
    target_compile_options(${target} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O0>)
  elseif(NOT CATAN_SANITIZE)
    # At -O1 GCC 12 takes optionals that are set for uninitialised: other modules still have that warning.
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1> $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  endif()
endfunction()

# catan_unity(TARGET): compiles the target's files as one, if CATAN_UNITY is on.
function(catan_unity target)
  if(CATAN_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    # What a source keeps to itself GCC takes for a header's, where the source is included.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# catan_test(NAME [SERIAL] SOURCES file... LIBRARIES target... REALTIME test... UNSANITIZED test...): a GoogleTest program, each
# of its tests known to CTest. REALTIME: tests, as GoogleTest's filters name them, that run threads
# against the clock, so that nothing may run beside them and another process can make them fail; SERIAL: all of its tests do. They
# have the label `realtime`, by which scripts/test.sh knows what to run alone and, if it fails, again. UNSANITIZED: tests, or cases
# of them, that are left out under sanitizers, since they compare figures at length, and others run the same code.
function(catan_test name)
  cmake_parse_arguments(ARG "SERIAL" "" "SOURCES;LIBRARIES;REALTIME;UNSANITIZED" ${ARGN})
  catan_check_names("${ARG_SOURCES}" ${ARG_REALTIME} ${ARG_UNSANITIZED})
  if(ARG_SERIAL)
    set(ARG_REALTIME *)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  catan_unity(${name})
  catan_test_options(${name})
  if(CATAN_UNITY)
    target_precompile_headers(${name} REUSE_FROM catan_test_headers)
  endif()
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gmock GTest::gtest_main rapidcheck)
  set(options DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60)
  if(NOT CATAN_SANITIZE)
    set(ARG_UNSANITIZED "")
  endif()
  list(JOIN ARG_REALTIME ":" realtime)
  list(JOIN ARG_UNSANITIZED ":" left_out)
  set(not_steady ${ARG_REALTIME} ${ARG_UNSANITIZED})
  list(JOIN not_steady ":" not_steady)
  if(CATAN_SANITIZE MATCHES "address" AND NOT ARG_SERIAL)
    # To start a program takes a tenth of a second then, and most tests far less: all in one go.
    add_test(NAME ${name} COMMAND ${name} --gtest_filter=-${not_steady})
    set_tests_properties(${name} PROPERTIES TIMEOUT 1200)
  elseif(NOT not_steady)
    gtest_discover_tests(${name} ${options} PROPERTIES TIMEOUT 300)
  elseif(NOT ARG_SERIAL)
    gtest_discover_tests(${name} ${options} TEST_FILTER "-${not_steady}" PROPERTIES TIMEOUT 300)
  endif()
  if(realtime)
    gtest_discover_tests(${name} ${options} TEST_FILTER "${realtime}-${left_out}" TEST_LIST ${name}_realtime
                         PROPERTIES TIMEOUT 300 RUN_SERIAL TRUE LABELS realtime)
  endif()
endfunction()

# catan_test_options(TARGET): how sources of tests are compiled.
function(catan_test_options target)
  # Most of the time that a test takes to compile would go into making it fast, which only what is tested needs to be.
  target_compile_options(${target} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O0>)
  # GCC makes a function of each std::move and std::forward otherwise.
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-ffold-simple-inlines>)
  target_include_directories(${target} SYSTEM PRIVATE ${rapidcheck_INCLUDE_DIRS})
endfunction()

# catan_precompile_test_headers(): the target catan_test_headers, whose precompiled headers all tests use: others' headers that
# most of them include (docs/decisions/0084-tests-share-precompiled-headers.md).
function(catan_precompile_test_headers)
  set(empty ${PROJECT_BINARY_DIR}/generated/test_headers.cpp)
  file(CONFIGURE OUTPUT ${empty} CONTENT "")
  add_library(catan_test_headers OBJECT EXCLUDE_FROM_ALL ${empty})
  catan_unity(catan_test_headers)
  catan_test_options(catan_test_headers)
  # As sources of programs are compiled, or the compiler would not take them.
  set_target_properties(catan_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
  target_compile_options(catan_test_headers PRIVATE -fPIE)
  target_link_libraries(catan_test_headers PRIVATE GTest::gmock rapidcheck)
  target_precompile_headers(catan_test_headers PRIVATE
    <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory> <mutex> <optional>
    <set> <span> <string> <string_view> <thread> <utility> <variant> <vector> <gmock/gmock.h> <gtest/gtest.h> <rapidcheck/gtest.h>)
endfunction()

# catan_check_names(SOURCES pattern...): each of these tests, as GoogleTest's filters name them, is of a suite in the sources: a
# filter that matches nothing would go unnoticed.
function(catan_check_names sources)
  set(text "")
  foreach(source IN LISTS sources)
    file(READ ${source} one)
    string(APPEND text "${one}")
  endforeach()
  foreach(pattern IN LISTS ARGN)
    string(REGEX REPLACE "^\\*/" "" suite "${pattern}")
    string(REGEX REPLACE "[./].*$" "" suite "${suite}")
    string(FIND "${text}" "(${suite}," found)
    if(found EQUAL -1)
      message(FATAL_ERROR "no test suite is named ${suite}, which '${pattern}' asks for")
    endif()
  endforeach()
endfunction()

# catan_as_one(NAME FOLDER...): the target NAME, which nothing builds, of all sources of the targets in and below these folders as
# one. `make lint` finds them by its compile command: most of clang-tidy's time goes into the headers that they share. Left out,
# and looked at alone, are sources of another C++ standard and those that cannot be joined with others; tests and what is
# generated are not looked at.
function(catan_as_one name)
  set(sources "")
  set(LINK_LIBRARIES "")
  set(INCLUDE_DIRECTORIES "")
  set(COMPILE_DEFINITIONS "")
  foreach(folder IN LISTS ARGN)
    catan_targets_below(${PROJECT_SOURCE_DIR}/${folder} targets)
    foreach(target IN LISTS targets)
      catan_sources_to_join(${target} joined)
      if(joined)
        list(APPEND sources ${joined})
        foreach(property LINK_LIBRARIES INCLUDE_DIRECTORIES COMPILE_DEFINITIONS)
          get_target_property(value ${target} ${property})
          if(value)
            list(APPEND ${property} ${value})
          endif()
        endforeach()
      endif()
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES sources)
  # Warnings in others' headers are no concern of ours. A target does not tell which of its folders have these.
  set(system_folders ${INCLUDE_DIRECTORIES})
  list(FILTER system_folders INCLUDE REGEX "^/usr/|^${PROJECT_BINARY_DIR}/generated")
  list(FILTER INCLUDE_DIRECTORIES EXCLUDE REGEX "^/usr/|^${PROJECT_BINARY_DIR}/generated")

  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${sources})
  target_include_directories(${name} PRIVATE ${INCLUDE_DIRECTORIES})
  target_include_directories(${name} SYSTEM PRIVATE ${system_folders})
  target_link_libraries(${name} PRIVATE ${LINK_LIBRARIES})
  target_compile_definitions(${name} PRIVATE ${COMPILE_DEFINITIONS})
  # Each program's main() gets a name of its own.
  string(JOIN "\n" rename_main "#define CATAN_JOIN(a, b) a##b" "#define CATAN_NAME(a, b) CATAN_JOIN(a, b)" "#undef main"
         "#define main CATAN_NAME(main_of_, CATAN_FILE)")
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0 UNITY_BUILD_UNIQUE_ID CATAN_FILE
                        UNITY_BUILD_CODE_BEFORE_INCLUDE "${rename_main}")
endfunction()

# The targets in the folder and below it.
function(catan_targets_below folder result)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below IN LISTS folders)
    catan_targets_below(${below} more)
    list(APPEND targets ${more})
  endforeach()
  set(${result} ${targets} PARENT_SCOPE)
endfunction()

# The target's sources, with their full paths, that catan_as_one() takes. None of a target that compiles nothing.
function(catan_sources_to_join target result)
  set(${result} "" PARENT_SCOPE)
  get_target_property(standard ${target} CXX_STANDARD)
  if(NOT standard EQUAL CMAKE_CXX_STANDARD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  list(TRANSFORM sources PREPEND ${folder}/ REGEX "^[^/]")
  list(FILTER sources EXCLUDE REGEX "^${PROJECT_BINARY_DIR}/")
  foreach(source IN LISTS sources)
    get_source_file_property(alone ${source} TARGET_DIRECTORY ${target} SKIP_UNITY_BUILD_INCLUSION)
    if(alone)
      list(REMOVE_ITEM sources ${source})
    endif()
  endforeach()
  set(${result} ${sources} PARENT_SCOPE)
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
