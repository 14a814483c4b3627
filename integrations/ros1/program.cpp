#include "ros1/program.h"

#include <pthread.h>
#include <ros/console.h>
#include <ros/this_node.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "ros1/nodelet_hooks.h"

namespace catan_ros {
namespace {

// After which a callback that a binding names should be there.
constexpr std::chrono::seconds kAllShouldBeThere{10};

// Whose callback it is.
std::string owner_of(const Binding& binding) {
  return binding.nodelet.empty() ? binding.ros_node : "nodelet " + binding.nodelet + " of " + binding.ros_node;
}

void tell(ServerConnection::Severity severity, const std::string& text) {
  if (severity == ServerConnection::Severity::kError) {
    ROS_ERROR("catan: %s", text.c_str());
  } else {
    ROS_WARN("catan: %s", text.c_str());
  }
}

void warn(const std::string& text) { tell(ServerConnection::Severity::kWarning, text); }

}  // namespace

Program::Program(std::vector<Binding> bindings, std::string messages_file)
    : all_bindings_(std::move(bindings)),
      messages_file_(std::move(messages_file)),
      message_runs_(messages_file_.empty() ? nullptr : MessageRuns::open(messages_file_)),
      connection_(tell) {}

// Precondition: mutex_ is held.
const std::vector<Binding>& Program::bindings() {
  if (!bindings_) {
    bindings_ = bindings_of(all_bindings_, ros::this_node::getName());
    if (bindings_->empty()) return *bindings_;
    if (message_runs_ == nullptr) {
      warn("cannot use the file " +
           (messages_file_.empty() ? "of messages, of which there is no name" : messages_file_) +
           "; which run sent a message is not known, and response times are guessed");
    }
    std::thread([this] { tell_missing(); }).detach();
  }
  return *bindings_;
}

bool Program::notes_messages() {
  const std::lock_guard lock(mutex_);
  const std::vector<Binding>& own = bindings();
  return message_runs_ != nullptr &&
         std::any_of(own.begin(), own.end(), [](const Binding& binding) { return !binding.predecessors.empty(); });
}

void Program::note_subscription(const std::string& topic, const ros::CallbackQueueInterface& queue) {
  const std::lock_guard lock(mutex_);
  if (message_runs_ == nullptr) return;
  const std::string nodelet = nodelet_of(queue);
  for (const Binding& binding : bindings()) {
    const bool may_take = binding.nodelet.empty() || nodelet.empty() || binding.nodelet == nodelet;
    if (may_take && !binding.predecessors.empty()) message_runs_->note_subscription(binding.node, topic);
  }
}

// A callback that is waited for may ask for another one.
void Program::give_up(const ros::CallbackQueueInterface* queue) {
  std::vector<BoundNode*> nodes;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& node : nodes_) nodes.push_back(node.get());
  }
  for (BoundNode* const node : nodes) node->give_up(queue);
}

bool Program::is_bound() {
  const std::lock_guard lock(mutex_);
  return !bindings().empty();
}

Program::CandidatePtr Program::find(Binding::Kind kind, const std::string& name, ros::CallbackQueueInterface& queue) {
  const std::lock_guard lock(mutex_);
  if (bindings().empty()) return nullptr;
  const std::string nodelet = nodelet_of(queue);
  asked_.note(kind, name, nodelet);
  return find(find_named(bindings(), kind, name, nodelet), queue);
}

Program::CandidatePtr Program::find_timer(std::chrono::nanoseconds period, ros::CallbackQueueInterface& queue) {
  const std::lock_guard lock(mutex_);
  if (bindings().empty()) return nullptr;
  const std::string nodelet = nodelet_of(queue);
  asked_.note_timer(period, nodelet);
  return find(catan_ros::find_timer(bindings(), period, nodelet), queue);
}

Program::CandidatePtr Program::find(const Binding* binding, ros::CallbackQueueInterface& queue) {
  if (binding == nullptr || stopped_.load()) return nullptr;
  const auto known =
      std::find_if(nodes_.begin(), nodes_.end(), [&](const auto& node) { return node->binding() == *binding; });
  if (known != nodes_.end()) return (*known)->add_candidate(queue);
  nodes_.push_back(std::make_unique<BoundNode>(*binding, message_runs_.get(), kept_, connection_));
  changed_.notify_all();
  return nodes_.back()->add_candidate(queue);
}

// By a thread of its own. In a program of one node it is one of the node's, so it sleeps, and ends when all are there.
void Program::tell_missing() {
  ::pthread_setname_np(::pthread_self(), "catan-missing");
  const auto until = std::chrono::steady_clock::now() + kAllShouldBeThere;
  std::unique_lock lock(mutex_);
  const auto is_over = [this] { return stopped_.load() || nodes_.size() == bindings_->size(); };
  changed_.wait_until(lock, until, is_over);
  if (stopped_.load()) return;
  for (const Binding& binding : *bindings_) {
    const bool is_there =
        std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& node) { return node->binding() == binding; });
    if (is_there) continue;
    warn(owner_of(binding) + " has not asked for " + describe(binding) + " in " +
         std::to_string(kAllShouldBeThere.count()) + " s, which is to be node " + binding.node + ": " +
         asked_.text_for(binding) + "; the others go on");
  }
  asked_.finish();
}

void Program::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_.store(true);
    changed_.notify_all();
    for (const auto& node : nodes_) node->stop();
  }
  connection_.stop();
}

}  // namespace catan_ros
