#include "ros1/test/roscore.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace catan_ros {
namespace {

bool is_free(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const bool bound = ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(socket);
  return bound;
}

// Below those that the kernel gives to connections: one of these may be taken again before roscore listens at it.
int free_port() {
  constexpr int kFirst = 20'000;
  constexpr int kPorts = 10'000;
  constexpr int kTries = 100;
  constexpr int kStep = 97;  // so that programs that begin one after the other do not look at the same ports
  for (int tries = 0; tries < kTries; ++tries) {
    const int port = kFirst + (::getpid() + tries * kStep) % kPorts;
    if (is_free(port)) return port;
  }
  throw std::runtime_error("there is no free port");
}

// It ends in order only from then on.
bool has_started(const std::string& log) {
  std::ostringstream text;
  text << std::ifstream(log).rdbuf();
  return text.str().find("started core service") != std::string::npos;
}

}  // namespace

Roscore::Roscore(const std::string& folder) : folder_(folder), port_(free_port()) {
  ::setenv("HOME", folder.c_str(), 1);
  ::setenv("ROS_HOME", folder.c_str(), 1);
  ::setenv("ROS_LOG_DIR", folder.c_str(), 1);
  ::setenv("ROS_MASTER_URI", ("http://localhost:" + std::to_string(port_)).c_str(), 1);
  ::setenv("ROS_HOSTNAME", "localhost", 1);
  ::setenv("PYTHONUNBUFFERED", "1", 1);
  start();
}

void Roscore::start() {
  const std::string log_file = folder_ + "/roscore.log";
  std::ofstream(log_file).close();
  process_ = ::fork();
  if (process_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    const int log = ::open(log_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    ::dup2(log, 1);
    ::dup2(log, 2);
    ::execl("/usr/bin/python3", "python3", "/usr/bin/roscore", "-p", std::to_string(port_).c_str(), nullptr);
    ::_exit(127);
  }
  for (int tries = 0; tries < 400; ++tries) {
    if (has_started(log_file)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds{50});
  }
  stop();
  throw std::runtime_error("roscore does not start: see " + log_file);
}

Roscore::~Roscore() { stop(); }

void Roscore::stop() {
  const int process = std::exchange(process_, 0);
  if (process <= 0) return;
  for (int tries = 0; tries < 200; ++tries) {
    // Again and again: it does not hear it while it starts.
    if (tries % 10 == 0) ::kill(process, SIGTERM);
    if (::waitpid(process, nullptr, WNOHANG) == process) return;
    std::this_thread::sleep_for(std::chrono::milliseconds{50});
  }
  ::kill(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
}

}  // namespace catan_ros
