// For tests that not every machine allows: what needs real-time privileges, root, a second CPU or a program that may be
// missing. Such a test is skipped, and says why and what to do. Where the environment has CATAN_REQUIRE_REALTIME=1,
// which continuous integration sets, it fails instead: a machine that is there to run every test may not leave one out
// unnoticed.
//
// Both macros return from the function that they are in, so they belong into a test's body or into SetUp().
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string_view>

#include "os/os.h"

namespace ctn::os {

inline bool every_test_must_run() {
  const char* const value = std::getenv("CATAN_REQUIRE_REALTIME");
  return value != nullptr && std::string_view(value) == "1";
}

}  // namespace ctn::os

// `reason`: what is missing and how to get it; anything that a stream takes.
#define CATAN_REQUIRE(condition, reason)                                           \
  do {                                                                             \
    if (condition) break;                                                          \
    if (::ctn::os::every_test_must_run()) {                                        \
      FAIL() << reason << " (and CATAN_REQUIRE_REALTIME=1 says that it is there)"; \
    }                                                                              \
    GTEST_SKIP() << reason;                                                        \
  } while (false)

// `system`: an Os.
#define CATAN_REQUIRE_REAL_TIME(system)                                                                               \
  do {                                                                                                                \
    const ::ctn::os::RealTimeFacts facts_of_machine = (system).real_time_facts();                                     \
    CATAN_REQUIRE(facts_of_machine.permitted, "needs the permission to set real-time levels; here: "                  \
                                                  << facts_of_machine.why_not << "; `catan doctor` says what to do"); \
  } while (false)
