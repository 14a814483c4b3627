// The public API on the real system: what a session does to its threads, and what it leaves behind.
#include <catan/session.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "os/linux/linux_os.h"
#include "os/requires_real_time.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class SessionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(app_file_) << R"(
catan: 1
app: pair
nodes: { sense: { fallback_rate: 20Hz }, act: {} }
edges: [ sense -> act ]
subchains: { pair: [sense, act] }
objective: [ { response_time: [sense, act], weight: 1 } ]
scheduler: { bootstrap: 500ms, replan: 200ms }
)";
  }
  void TearDown() override {
    std::filesystem::remove(app_file_);
    std::filesystem::remove(record_file_);
  }

  static std::string file(const std::string& ending) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return ::testing::TempDir() + "catan-" + test->name() + std::to_string(::getpid()) + ending;
  }

  void burn(Nanos duration) const {
    const Nanos end = os_->thread_cpu_time() + duration;
    while (os_->thread_cpu_time() < end) {
    }
  }

  Result<Session> open(const std::string& policy) {
    const int cpu = os_->affinity(os_->current_thread())->cpus().front();
    Result<Session> session = Session::open(
        app_file_, {.policy = policy, .cpus = {cpu}, .record = record_file_, .note = {}, .on_notice = {}});
    if (!session) return session;
    Channel<int>& channel = session->channel<int>("sense", "act");
    session->node("sense", [this, &channel](ctn::Run& run) {
      burn(milliseconds{5});
      channel.write(run, static_cast<int>(run.number()));
    });
    session->node("act", [this, &channel](ctn::Run& run) {
      const int* value = channel.read(run);
      if (value == nullptr || *value <= 0) ++surprises_;
      level_.store(*os_->level(os_->current_thread()));
      ++runs_;
      burn(milliseconds{10});
    });
    return session;
  }

  int real_time_threads() const {
    int count = 0;
    for (const os::ThreadId thread : *os_->threads(os_->current_process())) {
      const Result<os::Level> level = os_->level(thread);
      count += level && *level != os::Level::kOrdinary ? 1 : 0;
    }
    return count;
  }

  std::unique_ptr<os::Os> os_ = os::make_linux_os();
  std::string app_file_ = file(".yaml");
  std::string record_file_ = file(".db");
  std::atomic<int> surprises_{0};
  std::atomic<int> runs_{0};  // of act
  std::atomic<os::Level> level_{os::Level::kOrdinary};
};

TEST_F(SessionTest, RaisesItsThreadsMeasuresThemAndLeavesNoLevelBehind) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  Result<Session> session = open("catan");
  ASSERT_TRUE(session.ok()) << session.error().message();
  const Status started = session->start();
  ASSERT_TRUE(started.ok()) << started.error().message();
  std::this_thread::sleep_for(seconds{4});
  const Snapshot snapshot = session->snapshot();
  EXPECT_EQ(level_.load(), os::Level::kActive);
  EXPECT_EQ(real_time_threads(), 3) << "two nodes and the trigger thread";
  ASSERT_TRUE(session->stop().ok());
  EXPECT_EQ(real_time_threads(), 0);

  EXPECT_TRUE(snapshot.real_time);
  EXPECT_EQ(surprises_.load(), 0);
  ASSERT_GT(snapshot.chains[0].response_ms.count, 20U);
  // That what is predicted is what happens is checked to the nanosecond in virtual time (simulation_api_test.cpp,
  // WhatIsPredictedIsWhatHappens, with the app of this test). Here it is only looked whether the real clock and real
  // threads come to figures of the same kind. Below the costs that are burnt neither figure can be; a wrong unit, a
  // clock that stands or a chain that is hardly served is beyond the factor above, a busy machine is not.
  constexpr double kNoLoadAtAll = 15.0 + 15.0;
  constexpr double kGenerous = 10.0;
  const double predicted = snapshot.chains[0].predicted_response_ms.value_or(0.0);
  const double measured = snapshot.chains[0].response_ms.p50;
  EXPECT_GE(predicted, kNoLoadAtAll);
  EXPECT_LT(predicted, kGenerous * kNoLoadAtAll);
  EXPECT_GE(measured, 0.99 * kNoLoadAtAll) << "clocks of CPU time and of time may differ a little";
  EXPECT_LT(measured, kGenerous * kNoLoadAtAll);
  std::cout << "response time: predicted " << predicted << " ms, measured p50 " << measured << " ms\n";
}

TEST_F(SessionTest, HandSetRatesNeedNoPermission) {
  Result<Session> session = open("rate:10");
  ASSERT_TRUE(session.ok()) << session.error().message();
  ASSERT_TRUE(session->start().ok());
  for (int look = 0; runs_ < 3 && look < 1000; ++look) std::this_thread::sleep_for(milliseconds{20});
  EXPECT_GE(runs_, 3);
  EXPECT_EQ(real_time_threads(), 0);
  const Snapshot snapshot = session->snapshot();
  ASSERT_TRUE(session->stop().ok());
  EXPECT_EQ(snapshot.source_hz, 10.0);
  EXPECT_EQ(level_.load(), os::Level::kOrdinary);
}

TEST_F(SessionTest, DestroyedWhileItRunsItStopsCleanly) {
  {
    Result<Session> session = open("catan");
    ASSERT_TRUE(session.ok());
    ASSERT_TRUE(session->start().ok());
    std::this_thread::sleep_for(milliseconds{300});
  }
  EXPECT_EQ(real_time_threads(), 0);
  EXPECT_TRUE(std::filesystem::exists(record_file_));
}

TEST_F(SessionTest, ARecordIsNeverOverwritten) {
  std::ofstream(record_file_) << "precious";
  Result<Session> session = open("catan");
  ASSERT_TRUE(session.ok());
  const Status started = session->start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().kind(), ErrorKind::kCaller);
  std::string content;
  std::ifstream(record_file_) >> content;
  EXPECT_EQ(content, "precious");
}

TEST_F(SessionTest, AllThatIsWrongWithTheAppFileIsTold) {
  std::ofstream(app_file_) << "catan: 1\napp: x\nnodes: { a: { max_rate: 50 } }\nedge: []\n";
  const Result<Session> session = Session::open(app_file_, {});
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().kind(), ErrorKind::kCaller);
  EXPECT_GE(session.error().problems().size(), 2U);
}

}  // namespace
}  // namespace ctn
