// For the conformance suite: what its tests have in common. They are in src/os/conformance_*test.cpp;
// conformance_test.cpp names the implementations that all of them run on.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "os/os.h"
#include "os/testing/conformance.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os::conformance {

class OsConformance : public testing::TestWithParam<Port> {
 protected:
  Os& os() { return platform_->os(); }
  void work(Nanos cpu_time) { platform_->work(cpu_time); }
  Nanos at_once() const { return platform_->at_once(); }
  TimePoint soon() { return os().now() + kTimeout; }

  bool is_listed(ThreadId thread) {
    const auto found = os().threads(os().current_process());
    return found.ok() && std::find(found->begin(), found->end(), thread) != found->end();
  }

  // A system may list a thread for a moment after it has been joined.
  void await_gone(ThreadId thread) {
    for (const TimePoint end = soon(); is_listed(thread) && os().now() < end;)
      os().sleep_until(os().now() + std::chrono::milliseconds{1});
    ASSERT_FALSE(is_listed(thread));
  }

  ThreadId gone_thread() {
    Parked parked(os());
    parked.end();
    await_gone(parked.id());
    return parked.id();
  }

 private:
  std::unique_ptr<Platform> platform_ = GetParam().make();
};

// What a system that permits real-time levels does.
class RealTimeConformance : public OsConformance {
 protected:
  void SetUp() override { CATAN_REQUIRE_REAL_TIME(os()); }
};

// What one does that does not.
class ConformanceWithoutPermission : public OsConformance {};

#define EXPECT_ENVIRONMENT_ERROR(call)                            \
  do {                                                            \
    const auto result = (call);                                   \
    ASSERT_FALSE(result.ok());                                    \
    EXPECT_EQ(result.error().kind(), ErrorKind::kEnvironment);    \
    EXPECT_FALSE(result.error().problems().front().hint.empty()); \
  } while (false)

}  // namespace ctn::os::conformance
