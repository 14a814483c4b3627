// A program that runs one node of the pipeline (pipeline.h), and does what its tormentor says in the mapped state.
// Usage: fault_player SOCKET STATE NODE COST_US. It ends on SIGTERM, and with its parent; on SIGUSR1 it forks.
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "catan/client.h"
#include "os/linux/linux_os.h"
#include "state.h"

namespace {

using ctn::faults::NodeState;

void burn(ctn::os::Os& os, ctn::Nanos cpu) {
  for (const ctn::Nanos until = os.thread_cpu_time() + cpu; os.thread_cpu_time() < until;) continue;
}

void run_once(ctn::os::Os& os, NodeState& state, ctn::Run& run, ctn::Nanos cost) {
  if (run.number() <= state.number.load()) ++state.went_back;
  const std::int64_t began = os.now().time_since_epoch().count();
  state.began = began;
  const ctn::Nanos more{state.overrun.exchange(0)};
  burn(os, cost + more);
  // Busily, which is the worst that a run can do.
  while (state.hang != 0) state.hanging = 1;
  state.hanging = 0;
  state.number = run.number();
  state.ended = os.now().time_since_epoch().count();
  state.completed = began;
  if (more > ctn::Nanos{0}) state.overran = state.ended.load();
  ++state.runs;
}

// It holds whatever its parent had open, as careless programs' children do.
void fork_child(NodeState& state) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, 0);
    for (int tenth = 0; tenth < 50; ++tenth) ::usleep(100'000);
    ::_exit(0);
  }
  state.child = child;
}

int play(const std::string& socket, const std::string& file, std::size_t node, ctn::Nanos cost) {
  const auto os = ctn::os::make_linux_os();
  const ctn::faults::MappedState mapped(file, false);
  NodeState& state = mapped.node(node);
  ctn::ClientOptions options;
  options.socket = socket;
  options.app = "faults";
  options.on_notice = [&](const std::string& text) {
    if (text.find("it is gone") != std::string::npos || text.find("does nothing") != std::string::npos) {
      state.served = 0;
    }
    if (text.find("it schedules the nodes") != std::string::npos) state.served = 1;
  };
  auto client = ctn::Client::connect(options);
  if (!client) return std::fprintf(stderr, "%s\n", client.error().message().c_str()), 1;
  client->node(ctn::faults::kNodes.at(node), [&](ctn::Run& run) { run_once(*os, state, run, cost); });
  if (const auto started = client->start(); !started) {
    return std::fprintf(stderr, "%s\n", started.error().message().c_str()), 1;
  }
  state.served = 1;
  sigset_t set{};
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR1);
  for (int number = 0; ::sigwait(&set, &number) == 0 && number == SIGUSR1;) fork_child(state);
  client->stop();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  sigset_t set{};  // before there is any other thread
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGUSR1);
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  for (std::size_t node = 0; node < ctn::faults::kNodes.size(); ++node) {
    if (std::string(ctn::faults::kNodes.at(node)) != argv[3]) continue;
    return play(argv[1], argv[2], node, std::chrono::microseconds{std::atoi(argv[4])});
  }
  return 2;
}
