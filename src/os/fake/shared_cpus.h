// For tests: threads that burn on shared CPUs, and what came of it.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "base/testing/times.h"
#include "os/fake/fake_os.h"

namespace ctn::os {

// The test's own thread is at the dispatcher level, as a controller: it acts at once, whatever burns.
class SharedCpus : public testing::Test {
 protected:
  SharedCpus() {
    os.share_cpus(true);
    EXPECT_TRUE(os.set_level(ThreadId{1}, Level::kDispatcher).ok());
  }

  ThreadId spawn(const std::string& name, Level level, const CpuSet& cpus, std::function<void()> body) {
    threads_.push_back(os.spawn(name, [this, level, cpus, body = std::move(body)] {
      ASSERT_TRUE(os.set_level(os.current_thread(), level).ok());
      ASSERT_TRUE(os.set_affinity(os.current_thread(), cpus).ok());
      body();
    }));
    names_.push_back(name);
    return ThreadId{static_cast<std::int32_t>(names_.size()) + 1};
  }

  // Sleeps until `start`, which is not 0: at 0 the others are being made.
  ThreadId burner(const std::string& name, Level level, const CpuSet& cpus, Nanos start, Nanos amount) {
    return spawn(name, level, cpus, [this, name, start, amount] {
      os.sleep_until(at(start));
      os.burn(amount);
      ended[name] = os.now().time_since_epoch();
      EXPECT_EQ(os.thread_cpu_time(), amount);
    });
  }

  void join() { threads_.clear(); }

  // "0 a 1-5": CPU 0 served thread a from 1 ms to 5 ms.
  std::vector<std::string> stretches() {
    std::vector<std::string> lines;
    for (const FakeCpus::Stretch& stretch : os.stretches()) {
      lines.push_back(fmt::format("{} {} {}-{}", stretch.cpu, names_.at(static_cast<std::size_t>(stretch.thread) - 2),
                                  millis(stretch.begin), millis(stretch.end)));
    }
    return lines;
  }

  FakeOs os{fake_topology(3)};
  std::map<std::string, Nanos> ended;

 private:
  static Nanos::rep millis(TimePoint time) { return time.time_since_epoch() / std::chrono::milliseconds(1); }

  std::vector<std::string> names_;  // from thread 2 on
  std::vector<std::unique_ptr<Thread>> threads_;
};

}  // namespace ctn::os
