#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>
#include <thread>

#include "conformance/suite.h"

namespace ctn::conformance {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::atomic<bool> g_stop{false};

// Exit code, or 128 + signal; none within the time: killed, and 255.
int wait_for(int process, milliseconds timeout) {
  const auto until = steady_clock::now() + timeout;
  int status = 0;
  for (;;) {
    const int ended = ::waitpid(process, &status, WNOHANG);
    if (ended == process) break;
    if (ended < 0 && errno != EINTR) return 255;
    if (steady_clock::now() > until) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
      return 255;
    }
    std::this_thread::sleep_for(milliseconds{2});
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int start_command(const std::vector<std::string>& arguments) {
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const int process = ::fork();
  if (process == 0) {
    ::execv(words[0], words.data());
    ::_exit(127);
  }
  return process;
}

}  // namespace

PortSuite::PortSuite() {
  folder_ = testing::TempDir() + "catan-port-XXXXXX";
  if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("no folder " + folder_);
  ::setenv("CATAN_SOCKET", (folder_ + "/socket").c_str(), 1);
  void* const memory = ::mmap(nullptr, sizeof *counters_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  counters_ = new (memory) std::array<Counters, 8>;
}

PortSuite::~PortSuite() {
  while (!programs_.empty()) kill_program(programs_.back());
  if (server_ != 0) kill_server();
  ::munmap(counters_, sizeof *counters_);
  std::filesystem::remove_all(folder_);
}

void PortSuite::serve(const std::string& app, const std::string& scheduler) {
  app_file_ = folder_ + "/app.yaml";
  std::ofstream(app_file_) << "catan: 1\napp: conformance\n" << app << "scheduler: { bootstrap: 100ms }\n";
  server_ = start_command({CATAN_COMMAND, "serve", app_file_, "--socket", folder_ + "/socket", "--scheduler", scheduler,
                           "--record", folder_ + "/run" + std::to_string(++records_), "--flight-recorder", "0"});
}

void PortSuite::kill_server() {
  ::kill(server_, SIGKILL);
  wait_for(server_, std::chrono::seconds{5});
  server_ = 0;
}

nlohmann::json PortSuite::report() {
  ::kill(server_, SIGTERM);
  EXPECT_EQ(wait_for(server_, std::chrono::seconds{10}), 0) << "the server ends in order";
  server_ = 0;
  const std::string out = folder_ + "/report.json";
  const std::string command =
      std::string(CATAN_COMMAND) + " report --all --json " + folder_ + "/run" + std::to_string(records_) + " > " + out;
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream text(out);
  return nlohmann::json::parse(text, nullptr, false);
}

PortSuite::Program PortSuite::start(const std::vector<Node>& nodes) {
  std::fflush(nullptr);
  const int process = ::fork();
  if (process == 0) {
    ::signal(SIGTERM, [](int) { g_stop.store(true); });
    ::_exit(GetParam().make()->run(nodes, g_stop));
  }
  programs_.push_back(process);
  return process;
}

void PortSuite::kill_program(Program program) {
  ::kill(program, SIGKILL);
  wait_for(program, std::chrono::seconds{5});
  std::erase(programs_, program);
}

int PortSuite::stop(Program program) {
  ::kill(program, SIGTERM);
  std::erase(programs_, program);
  return wait_for(program, std::chrono::seconds{10});
}

Node PortSuite::counting(std::size_t index, const std::string& name, const std::vector<Node::Input>& inputs,
                         const std::function<void(Call&)>& work) {
  Counters& counters = of(index);
  Node node;
  node.name = name;
  node.inputs = inputs;
  node.callback = [&counters, inputs, work](Call& call) {
    ++counters.begun;
    for (const Node::Input& input : inputs) {
      for (const std::int64_t message : call.take(input.from)) {
        const std::int64_t before = counters.newest.exchange(message);
        ++counters.received;
        if (message != before + 1) ++counters.gaps;
        if (message <= before) ++counters.backward;
      }
    }
    if (work) {
      work(call);
    } else {
      call.publish(++counters.published);
    }
    ++counters.ended;
  };
  return node;
}

void PortSuite::publish_next(Call& call, std::size_t index, std::size_t taker) {
  Counters& counters = of(index);
  if (of(taker).newest < counters.published) ++counters.overtaken;
  call.publish(++counters.published);
}

bool PortSuite::called(std::size_t node, std::int64_t more, milliseconds within) {
  const std::int64_t goal = of(node).ended.load() + more;
  const auto until = steady_clock::now() + within;
  while (of(node).ended.load() < goal) {
    if (steady_clock::now() > until) return false;
    std::this_thread::sleep_for(milliseconds{2});
  }
  return true;
}

nlohmann::json PortSuite::node(const nlohmann::json& report, const std::string& name) {
  for (const nlohmann::json& entry : report.value("nodes", nlohmann::json::array())) {
    if (entry["node"] == name) return entry;
  }
  return nlohmann::json::object();
}

void PortSuite::burn(std::chrono::microseconds cpu_time) {
  timespec used{};
  const auto now = [&] {
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return std::chrono::seconds{used.tv_sec} + std::chrono::nanoseconds{used.tv_nsec};
  };
  const auto end = now() + cpu_time;
  while (now() < end) {
  }
}

}  // namespace ctn::conformance
