// For tests of `catan serve`: the real command, and programs that run nodes of a small app, here and in processes of
// their own.
#pragma once

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "catan/client.h"
#include "os/linux/child_process.h"
#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"

namespace ctn::test {

using std::chrono::milliseconds;
using std::chrono::seconds;

inline bool eventually(const std::function<bool()>& holds, std::chrono::nanoseconds within = seconds{10}) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(milliseconds{1});
  }
  return true;
}

inline void burn(os::Os& os, Nanos cpu) {
  const Nanos until = os.thread_cpu_time() + cpu;
  while (os.thread_cpu_time() < until) {
  }
}

// Two subchains: `fast` of the nodes eye and hand, `slow` of the node map, which takes what eye gives.
inline std::string served_app(
    const std::string& nodes = "{ eye: { fallback_rate: 50Hz }, hand: {}, map: { fallback_rate: 20Hz } }") {
  return "catan: 1\napp: served\nnodes: " + nodes + R"(
edges: [ eye -> hand, eye -> map ]
subchains: { fast: [eye, hand], slow: [map] }
objective:
  - { response_time: [eye, hand], weight: 1 }
  - { period: map, weight: 0.1 }
scheduler: { bootstrap: 200ms, bootstrap_cost: 2ms }
)";
}
constexpr const char* kServedCosts = "eye: 1ms\nhand: 1ms\nmap: 4ms\n";

class ServedAppTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "catan-served-XXXXXX").string();
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr);
    std::ofstream(path("app.yaml")) << served_app();
    std::ofstream(path("costs.yaml")) << kServedCosts;
  }
  void TearDown() override {
    programs_.clear();
    server_.reset();
    // A server that was killed may just be having its last seconds saved.
    eventually([this] {
      std::error_code busy;
      std::filesystem::remove_all(folder_, busy);
      return !busy;
    });
  }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  // On one CPU, if no others are named, so that both subchains share it. The socket is in the test's folder. `more`:
  // options, as a shell takes them.
  void serve(const std::string& socket = "socket", const std::string& app = "app.yaml", const std::string& cpus = "",
             const std::string& more = "") {
    std::vector<std::string> arguments{
        "/bin/sh",
        "-c",
        "exec \"$0\" serve \"$1\" --socket \"$2\" --cpus \"$3\" --save-to \"${4%/*}\" " + more + " 2>>\"$4\"",
        CATAN_COMMAND,
        path(app),
        path(socket),
        cpus.empty() ? std::to_string(os_->online_cpus()->cpus().front()) : cpus,
        path("said")};
    Result<os::ChildProcess> started = os::ChildProcess::start(arguments);
    ASSERT_TRUE(started.ok()) << started.error().message();
    server_.emplace(std::move(*started));
  }
  os::Exit kill_server(int signal) {
    EXPECT_TRUE(server_->signal(signal).ok());
    std::optional<os::Exit> exit;
    EXPECT_TRUE(eventually([&] { return (exit = server_->wait()).has_value(); }));
    server_.reset();
    return exit.value_or(os::Exit{});
  }
  // A process that plays nodes. Its number.
  os::ChildProcess& play(const std::vector<std::string>& nodes) {
    std::vector<std::string> arguments{CATAN_COMMAND, "node", path("app.yaml")};
    arguments.insert(arguments.end(), nodes.begin(), nodes.end());
    for (const std::string& more :
         {std::string("--synthetic"), path("costs.yaml"), std::string("--socket"), path("socket")}) {
      arguments.push_back(more);
    }
    Result<os::ChildProcess> started = os::ChildProcess::start(arguments);
    EXPECT_TRUE(started.ok()) << started.error().message();
    return *programs_.emplace_back(std::make_unique<os::ChildProcess>(std::move(*started)));
  }
  // Starts a command that watches the app, whose nodes may run on the first CPU alone, and expects it to leave that
  // CPU.
  void expect_off_the_apps_cpu(const std::string& viewer) {
    const std::vector<int> cpus = os_->online_cpus()->cpus();
    CATAN_REQUIRE(cpus.size() >= 2, "needs two CPUs: one for the app, one for who watches");
    Result<os::ChildProcess> started = os::ChildProcess::start(
        {"/bin/sh", "-c", "exec \"$0\" " + viewer + " >\"$1\" 2>&1", CATAN_COMMAND, path("shown")});
    ASSERT_TRUE(started.ok()) << started.error().message();
    EXPECT_TRUE(eventually([&] {
      cpu_set_t allowed;
      return ::sched_getaffinity(static_cast<pid_t>(started->process()), sizeof allowed, &allowed) == 0 &&
             CPU_ISSET(cpus.front(), &allowed) == 0;
    })) << viewer;
  }
  // What the server said so far.
  std::string said() const {
    std::ifstream file(path("said"));
    return {std::istreambuf_iterator<char>(file), {}};
  }
  bool says(const std::string& text) {
    return eventually([&] { return said().find(text) != std::string::npos; });
  }
  int times_said(const std::string& text) const {
    const std::string all = said();
    int count = 0;
    for (std::size_t at = 0; (at = all.find(text, at)) != std::string::npos; ++at) ++count;
    return count;
  }
  std::vector<os::ThreadId> raised_of(os::ProcessId process) const {
    Result<std::vector<os::ThreadId>> threads = os_->threads(process);
    if (!threads) return {};
    threads->erase(std::remove_if(threads->begin(), threads->end(),
                                  [&](os::ThreadId thread) {
                                    const Result<os::Level> level = os_->level(thread);
                                    return !level || *level == os::Level::kOrdinary;
                                  }),
                   threads->end());
    return *std::move(threads);
  }
  int raised_threads(os::ProcessId process) const { return static_cast<int>(raised_of(process).size()); }
  std::vector<std::string> names_of_raised(os::ProcessId process) const {
    std::vector<std::string> raised;
    for (const os::ThreadId thread : raised_of(process)) {
      std::ifstream comm("/proc/" + std::to_string(static_cast<int>(thread)) + "/comm");
      std::string& name = raised.emplace_back();
      std::getline(comm, name);
      const Result<os::Level> level = os_->level(thread);
      name += level ? " at level " + std::to_string(static_cast<int>(*level)) : " gone";
    }
    return raised;
  }
  // The server's guardian; 0: it has none.
  pid_t guardian_of_server() const {
    const std::string tasks = "/proc/" + std::to_string(static_cast<int>(server_->process())) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
      std::ifstream children(task.path() / "children");
      for (pid_t child = 0; children >> child;) {
        std::string name;
        std::ifstream comm("/proc/" + std::to_string(child) + "/comm");
        if (std::getline(comm, name) && name == "catan-guard") return child;
      }
    }
    return 0;
  }
  Result<Client> connect(std::function<void(const std::string&)> on_notice = {}) {
    ClientOptions options;
    options.on_notice = std::move(on_notice);
    options.socket = path("socket");
    options.app = "served";
    return Client::connect(options);
  }

  std::unique_ptr<os::Os> os_ = os::make_linux_os();
  std::string folder_;
  std::optional<os::ChildProcess> server_;
  std::vector<std::unique_ptr<os::ChildProcess>> programs_;
};

// Nodes of the app in this process, which count their runs.
class CountingNodes {
 public:
  CountingNodes(Client client, os::Os& os, const std::vector<std::pair<std::string, Nanos>>& nodes)
      : client_(std::move(client)) {
    for (const auto& [name, cost] : nodes) {
      client_.node(name, [this, &os, cost = cost](Run&) {
        burn(os, cost);
        ++runs;
      });
    }
    const Status started = client_.start();
    EXPECT_TRUE(started.ok()) << (started.ok() ? "" : started.error().message());
  }

  bool runs_on(int more = 5, std::chrono::nanoseconds within = seconds{10}) {
    const int before = runs;
    return eventually([&] { return runs >= before + more; }, within);
  }
  Client& client() { return client_; }

  std::atomic<int> runs{0};

 private:
  Client client_;
};

// All three nodes of the app run: two here, one in a process of its own.
class ServedNodesTest : public ServedAppTest {
 protected:
  void TearDown() override {
    fast_.reset();
    ServedAppTest::TearDown();
  }
  // `more`, `cpus`: as serve() takes them.
  void serve_all(const std::string& more = "", const std::string& cpus = "") {
    serve("socket", "app.yaml", cpus, more);
    play({"map"});
    Result<Client> client = connect();
    ASSERT_TRUE(client.ok()) << client.error().message();
    fast_ = std::make_unique<CountingNodes>(
        std::move(*client), *os_,
        std::vector<std::pair<std::string, Nanos>>{{"eye", milliseconds{1}}, {"hand", milliseconds{1}}});
    ASSERT_TRUE(fast_->runs_on(20)) << said();
  }

  std::unique_ptr<CountingNodes> fast_;
};

}  // namespace ctn::test
