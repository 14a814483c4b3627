// The public API on the real system: what a session does to its threads, and what it leaves behind.
#include <catan/client.h>
#include <catan/session.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "os/linux/forked_process.h"
#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"

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
  EXPECT_THAT(level_.load(), testing::AnyOf(os::Level::kActive, os::fixed_level(0)))
      << "cores of its own, or the one priority that there is";
  EXPECT_EQ(real_time_threads(), 3) << "two nodes and the controller";
  ASSERT_TRUE(session->stop().ok());
  EXPECT_EQ(real_time_threads(), 0);

  EXPECT_TRUE(snapshot.real_time);
  EXPECT_EQ(surprises_.load(), 0);
  ASSERT_GT(snapshot.chains[0].response_ms.count, 20U);
  // That what is predicted is what happens is checked to the nanosecond in virtual time (simulation_api_test.cpp,
  // WhatIsPredictedIsWhatHappens, with the app of this test). Here it is only looked whether the real clock and real
  // threads come to figures of the same kind. Below the costs that are burnt neither figure can be; a wrong unit, a
  // clock that stands or a chain that is hardly served is beyond `kGenerous`, a busy machine is not.
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

TEST_F(SessionTest, AForkedChildLeavesItAlone) {
  CATAN_REQUIRE_REAL_TIME(*os_);
  Result<Session> session = open("catan");
  ASSERT_TRUE(session.ok());
  ASSERT_TRUE(session->start().ok());
  const auto runs_on = [&] {
    const int before = runs_;
    for (int look = 0; runs_ < before + 10 && look < 1000; ++look) std::this_thread::sleep_for(milliseconds{10});
    return runs_ >= before + 10;
  };
  ASSERT_TRUE(runs_on());
  ASSERT_GT(real_time_threads(), 0);

  os::ForkedProcess child([&] {
    ::alarm(20);
    const auto refused = [](const Status& done) { return !done && done.error().kind() == ErrorKind::kCaller; };
    const bool all_refused = refused(session->start()) && refused(session->adopt_this_thread("act")) &&
                             refused(session->tick("act")) && refused(session->change({})) &&
                             refused(session->save_flight(record_file_ + ".child"));
    session->node("act", [](ctn::Run&) {});
    static_cast<void>(session->channel<double>("sense", "act"));
    const bool nothing_shown = session->snapshot().chains.empty();
    const bool stopped = session->stop().ok();
    { const Session destroyed = std::move(*session); }
    return all_refused && nothing_shown && stopped ? 0 : 1;
  });
  EXPECT_EQ(child.join(), 0) << "negative: the signal that ended it";
  EXPECT_GT(real_time_threads(), 0);
  EXPECT_TRUE(runs_on());
  EXPECT_TRUE(session->stop().ok());
  EXPECT_EQ(real_time_threads(), 0);
}

// Of a user who has all the threads that the limit allows.
TEST_F(SessionTest, WhereNoThreadCanBeMadeNeitherSessionNorClientStarts) {
  os::ForkedProcess child([&] {
    ::alarm(20);
    // Sanitizers have threads of their own.
    const auto threads = [&] { return os_->threads(os_->current_process())->size(); };
    const std::size_t before = threads();
    const rlimit none{0, 0};
    if (::geteuid() == 0 && !os::become_nobody()) return 1;
    if (::setrlimit(RLIMIT_NPROC, &none) != 0) return 2;
    const auto refused = [](const auto& result) {
      return !result && result.error().kind() == ErrorKind::kEnvironment &&
             result.error().message().find("ulimit -u") != std::string::npos;
    };
    record_file_.clear();
    Result<Session> session = open("catan");
    if (!session) return 3;
    if (!refused(session->start())) return 4;
    if (!session->stop()) return 5;
    if (!refused(Client::connect({.socket = "/nowhere", .app = {}, .wait_seconds = 0.0, .on_notice = {}}))) return 6;
    return threads() == before ? 0 : 7;
  });
  EXPECT_EQ(child.join(), 0) << "negative: the signal that ended it";
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

// --- CPUs that are taken from the process, and given back ---

class TakenCpusTest : public SessionTest {
 protected:
  void SetUp() override {
    SessionTest::SetUp();
    main_cpus_ = *os_->affinity(main_);
    CATAN_REQUIRE(main_cpus_.size() >= 2, "needs two CPUs that this process may use; here: " << main_cpus_.size());
    kept_ = os::CpuSet{main_cpus_.cpus()[1]};
    Result<Session> opened = Session::open(
        app_file_, {.cpus = {main_cpus_.cpus()[0], main_cpus_.cpus()[1]}, .record = {}, .note = {}, .on_notice = {}});
    ASSERT_TRUE(opened.ok()) << opened.error().message();
    session_ = std::make_unique<Session>(std::move(*opened));
    session_->node("sense", [this](ctn::Run&) { work(); });
    session_->node("act", [this](ctn::Run&) { work(); });
    ASSERT_TRUE(session_->start().ok());
    ASSERT_TRUE(eventually([&] { return elsewhere_ + here_ > 20; }));
  }
  void TearDown() override {
    session_.reset();
    if (!main_cpus_.empty()) static_cast<void>(os_->set_affinity(main_, main_cpus_));
    SessionTest::TearDown();
  }

  template <class Condition>
  static bool eventually(const Condition& condition) {
    for (int look = 0; look < 500; ++look) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds{20});
    }
    return condition();
  }
  void work() {
    ++(kept_.contains(os_->current_cpu()) ? here_ : elsewhere_);
    burn(milliseconds{2});
  }
  // That the newest notice says so: it is told within 150 ms where the machine is not busy.
  bool plans_for(const os::CpuSet& cpus) {
    const std::string said = " " + os::to_string(cpus) + " are online and allowed: planning for these";
    return eventually([&] {
      const Snapshot snapshot = session_->snapshot();
      return !snapshot.notices.empty() && snapshot.notices.back().ends_with(said);
    });
  }
  // No node runs where it may not while it runs so many times.
  bool stays_here(int runs) {
    std::this_thread::sleep_for(milliseconds{300});  // runs that were under way
    elsewhere_ = 0;
    here_ = 0;
    return eventually([&] { return here_ >= runs; }) && elsewhere_ == 0;
  }

  const os::ThreadId main_ = os_->main_thread(os_->current_process());
  os::CpuSet main_cpus_;
  os::CpuSet kept_;
  std::atomic<int> here_{0};  // runs on the CPU that is kept
  std::atomic<int> elsewhere_{0};
  std::unique_ptr<Session> session_;
};

TEST_F(TakenCpusTest, ByATasksetOfTheProcess) {
  ASSERT_TRUE(os_->set_affinity(main_, kept_).ok());
  EXPECT_TRUE(plans_for(kept_));
  EXPECT_TRUE(stays_here(20));
  ASSERT_TRUE(os_->set_affinity(main_, main_cpus_).ok());
  EXPECT_TRUE(plans_for(os::CpuSet{main_cpus_.cpus()[0], main_cpus_.cpus()[1]}));
}

TEST_F(TakenCpusTest, ByATasksetOfAllItsThreads) {
  const auto bind_all = [&](const os::CpuSet& cpus) {
    for (const os::ThreadId thread : *os_->threads(os_->current_process())) {
      EXPECT_TRUE(os_->set_affinity(thread, cpus).ok());
    }
  };
  bind_all(kept_);
  EXPECT_TRUE(plans_for(kept_));
  EXPECT_TRUE(stays_here(20));
  bind_all(main_cpus_);
  EXPECT_TRUE(plans_for(os::CpuSet{main_cpus_.cpus()[0], main_cpus_.cpus()[1]}));
}

// A cpuset of the older kind (cgroup v1), which root can make without asking those above it.
class MadeCpuset {
 public:
  explicit MadeCpuset(const std::string& name) : folder_(std::string(kRoot) + "/" + name) {
    std::error_code failed;
    std::filesystem::create_directory(folder_, failed);
    made_ = !failed && write("cpuset.mems", read(std::string(kRoot) + "/cpuset.mems"));
  }
  ~MadeCpuset() {
    std::ofstream(std::string(kRoot) + "/cgroup.procs") << ::getpid();
    std::error_code ignored;
    std::filesystem::remove(folder_, ignored);
  }
  MadeCpuset(const MadeCpuset&) = delete;
  MadeCpuset& operator=(const MadeCpuset&) = delete;

  bool holds(const os::CpuSet& cpus) { return made_ && write("cpuset.cpus", os::to_string(cpus)); }
  bool enter() { return write("cgroup.procs", std::to_string(::getpid())); }

 private:
  static constexpr const char* kRoot = "/sys/fs/cgroup/cpuset";
  static std::string read(const std::string& path) {
    std::string text;
    std::getline(std::ifstream(path) >> std::ws, text);
    return text;
  }
  bool write(const std::string& file, const std::string& text) {
    std::ofstream stream(folder_ + "/" + file);
    stream << text << std::flush;
    return stream.good();
  }

  std::string folder_;
  bool made_ = false;
};

TEST_F(TakenCpusTest, ByTheCpusetOfTheProcess) {
  const std::string original = [] {
    std::ifstream cgroups("/proc/self/cgroup");
    std::string line;
    while (std::getline(cgroups, line)) {
      if (line.find(":cpuset:") != std::string::npos) return line.substr(line.rfind(':') + 1);
    }
    return std::string();
  }();
  if (original != "/") {
    GTEST_SKIP() << "needs to be in the root of a cgroup v1 hierarchy of cpusets; here: "
                 << (original.empty() ? "there is none" : original);
  }
  const os::CpuSet both{main_cpus_.cpus()[0], main_cpus_.cpus()[1]};
  MadeCpuset cpuset("catan-" + std::to_string(::getpid()));
  CATAN_REQUIRE(cpuset.holds(both) && cpuset.enter(), "needs root, to make a cpuset");
  ASSERT_TRUE(cpuset.holds(kept_));
  EXPECT_TRUE(plans_for(kept_));
  EXPECT_TRUE(stays_here(20));
  ASSERT_TRUE(cpuset.holds(both));
  EXPECT_TRUE(plans_for(both));
}

}  // namespace
}  // namespace ctn
