#include "illixr/program.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace catan_illixr {
namespace {

constexpr std::chrono::seconds kWaitForServer{2};
constexpr std::chrono::milliseconds kBetweenLooks{5};

}  // namespace

using catan_ros::Binding;
using catan_ros::LocalCallback;
using catan_ros::NodeRuns;
using catan_ros::Runs;
using catan_ros::ServerConnection;

Program::Program(std::vector<Binding> bindings, std::unique_ptr<catan_ros::MessageRuns> message_runs,
                 ServerConnection::Tell tell)
    : bindings_(std::move(bindings)),
      message_runs_(std::move(message_runs)),
      tell_(std::move(tell)),
      connection_(tell_) {}

void Program::start() {
  connecting_ = std::thread([this] { connection_.client(stopped_); });
  const auto until = std::chrono::steady_clock::now() + kWaitForServer;
  while (!connection_.connected() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(kBetweenLooks);
}

void Program::stop() {
  if (stopped_.exchange(true)) return;
  connection_.stop();
  if (connecting_.joinable()) connecting_.join();
  for (LocalCallback& callback : callbacks_) callback.stop();
}

void Program::note_plugin(std::size_t id, const std::string& name) {
  const std::lock_guard lock(mutex_);
  plugins_[id] = name;
}

catan_ros::LocalTopic& Program::find_topic(const std::string& name) {
  const std::lock_guard lock(mutex_);
  return topics_.try_emplace(name, name).first->second;
}

// Precondition: mutex_ is held.
const Binding* Program::find(std::size_t plugin, Binding::Kind kind, const std::string& topic) const {
  const auto name = plugins_.find(plugin);
  if (name == plugins_.end()) return nullptr;
  const auto found = std::find_if(bindings_.begin(), bindings_.end(), [&](const Binding& binding) {
    return binding.ros_node == name->second && binding.kind == kind && binding.name == topic;
  });
  return found == bindings_.end() ? nullptr : &*found;
}

catan_ros::LoopHook* Program::find_loop(std::size_t plugin) {
  const std::lock_guard lock(mutex_);
  const Binding* const binding = find(plugin, Binding::Kind::kLoop, {});
  if (binding == nullptr) return nullptr;
  const auto attach = [this, node = binding->node, tries = ServerConnection::Tries{},
                       next = std::chrono::steady_clock::time_point{}]() mutable -> std::unique_ptr<Runs> {
    const auto now = std::chrono::steady_clock::now();
    if (now < next) return nullptr;
    if (std::optional<ctn::AttachedNode> attached = connection_.try_attach(node, tries)) {
      return std::make_unique<NodeRuns>(*attached);
    }
    if (tries.refused) next = now + ServerConnection::kTryAgainWhenRefused;
    return nullptr;
  };
  return &loops_.emplace_back(*binding, *message_runs_, attach);
}

catan_ros::CallbackHook* Program::bind(std::size_t plugin, const std::string& topic,
                                       std::function<void(const Message&)> call) {
  LocalCallback* callback = nullptr;
  {
    const std::lock_guard lock(mutex_);
    const Binding* const binding = find(plugin, Binding::Kind::kTopic, topic);
    if (binding == nullptr) return nullptr;
    const bool is_there =
        std::any_of(callbacks_.begin(), callbacks_.end(), [&](const auto& one) { return one.binding() == *binding; });
    if (is_there) {
      tell_(ServerConnection::Severity::kWarning, "plugin " + binding->ros_node + " has another callback of " + topic +
                                                      "; the first one is node " + binding->node +
                                                      ", the other is not scheduled");
      return nullptr;
    }
    const auto attach = [this, node = binding->node](const std::atomic<bool>& stop) -> std::unique_ptr<Runs> {
      const std::optional<ctn::AttachedNode> attached = connection_.attach(node, stop, [] {});
      return attached ? std::make_unique<NodeRuns>(*attached) : nullptr;
    };
    callback = &callbacks_.emplace_back(*binding, *message_runs_, attach, std::move(call));
  }
  callback->start();
  find_topic(topic).add(*callback);
  return callback;
}

}  // namespace catan_illixr
