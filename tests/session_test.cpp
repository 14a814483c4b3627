// The public API on the real system: what a session does to its threads, and that what it predicts is what happens.
// Bounds are generous: other programs run on this machine too.
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
  std::atomic<os::Level> level_{os::Level::kOrdinary};
};

TEST_F(SessionTest, PredictsWhatHappensAndLeavesNoLevelBehind) {
  const os::RealTimeFacts facts = os_->real_time_facts();
  if (!facts.permitted) GTEST_SKIP() << "needs the permission to set real-time levels: " << facts.why_not;
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
  const double predicted = snapshot.chains[0].predicted_response_ms.value_or(0.0);
  EXPECT_NEAR(predicted, 15.0 + 15.0 / 0.94, 8.0);
  EXPECT_LT(snapshot.chains[0].response_ms.p50, 2.0 * predicted);
  std::cout << "response time: predicted " << predicted << " ms, measured p50 " << snapshot.chains[0].response_ms.p50
            << " ms\n";
}

TEST_F(SessionTest, HandSetRatesNeedNoPermission) {
  Result<Session> session = open("rate:10");
  ASSERT_TRUE(session.ok()) << session.error().message();
  ASSERT_TRUE(session->start().ok());
  std::this_thread::sleep_for(seconds{2});
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
