#include "common/executor_program.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <utility>

#include "common/node_runs.h"

namespace catan_ros {
namespace {

constexpr std::chrono::seconds kWaitForServerThere{2};
constexpr std::chrono::milliseconds kBetweenLooksForServer{5};

}  // namespace

std::unique_ptr<ExecutorProgram> ExecutorProgram::from_environment(const ServerConnection::Tell& tell) {
  const char* const text = std::getenv(kBindingsVariable);
  if (text == nullptr || std::getenv("CATAN_SOCKET") == nullptr) return nullptr;
  const std::optional<std::vector<Binding>> bindings = parse_bindings(text);
  const char* const path = std::getenv(kRunTimesVariable);
  auto run_times = RunTimes::open(path != nullptr ? path : "");
  if (!run_times) {
    tell(ServerConnection::Severity::kWarning,
         std::string("there is no file ") + path + "; which run sent a message is not known across programs");
    run_times = RunTimes::open({});
  }
  if (bindings && run_times) {
    return std::unique_ptr<ExecutorProgram>(new ExecutorProgram(*bindings, std::move(run_times), tell));
  }
  tell(ServerConnection::Severity::kError,
       std::string(kBindingsVariable) + " is not understood, or there is no memory; nothing is scheduled");
  return nullptr;
}

ExecutorProgram::ExecutorProgram(const std::vector<Binding>& bindings, std::unique_ptr<RunTimes> run_times,
                                 ServerConnection::Tell tell)
    : tell_(std::move(tell)), run_times_(std::move(run_times)), connection_(tell_) {
  for (const Binding& binding : bindings) {
    const auto attach = [this, node = binding.node](const std::atomic<bool>& stop,
                                                    const std::function<void()>& settled) -> std::unique_ptr<Runs> {
      if (!connection_.connected()) settled();
      const std::optional<ctn::AttachedNode> attached = connection_.attach(node, stop, settled);
      return attached ? std::make_unique<NodeRuns>(*attached) : nullptr;
    };
    callbacks_.emplace_back(binding, *run_times_, attach);
  }
}

void ExecutorProgram::start() {
  connecting_ = std::thread([this] { connection_.client(stopped_); });
  const auto until = std::chrono::steady_clock::now() + kWaitForServerThere;
  while (!connection_.connected() && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kBetweenLooksForServer);
  }
}

void ExecutorProgram::stop() {
  if (stopped_.exchange(true)) return;
  connection_.stop();
  if (connecting_.joinable()) connecting_.join();
  for (ExecutorCallback& callback : callbacks_) callback.stop();
}

ExecutorCallback* ExecutorProgram::find(const std::string& ros_node, Binding::Kind kind, const std::string& name,
                                        std::chrono::nanoseconds period) {
  return find_by_period(period, [&](const auto& fits) {
    const auto found = std::find_if(callbacks_.begin(), callbacks_.end(), [&](const ExecutorCallback& one) {
      const Binding& binding = one.binding();
      return binding.ros_node == ros_node && binding.kind == kind && binding.name == name && fits(binding.period);
    });
    return found != callbacks_.end() ? &*found : nullptr;
  });
}

}  // namespace catan_ros
