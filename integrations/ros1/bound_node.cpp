#include "ros1/bound_node.h"

#include <boost/make_shared.hpp>
#include <ros/console.h>
#include <signal.h>

#include <chrono>
#include <mutex>
#include <utility>

#include "ros1/turns_of_queues.h"

namespace catan_ros {
namespace {

constexpr std::chrono::milliseconds kTryAgain{100};

thread_local BoundNode* t_node = nullptr;

Outcome to_outcome(ros::CallbackInterface::CallResult result) {
  switch (result) {
    case ros::CallbackInterface::Success: return Outcome::kCalled;
    case ros::CallbackInterface::TryAgain: return Outcome::kAgain;
    case ros::CallbackInterface::Invalid: break;
  }
  return Outcome::kNothing;
}

// A call that waited for the node and goes to the program's queue after all.
class HandedOn final : public ros::CallbackInterface {
 public:
  explicit HandedOn(std::function<Outcome()> call) : call_(std::move(call)) {}
  CallResult call() override {
    switch (call_()) {
      case Outcome::kCalled: return Success;
      case Outcome::kAgain: return TryAgain;
      case Outcome::kNothing: break;
    }
    return Invalid;
  }

 private:
  std::function<Outcome()> call_;
};

class NodeSchedule final : public Schedule {
 public:
  explicit NodeSchedule(ctn::AttachedNode node) : node_(node) {}
  bool wait() override { return node_.wait(); }
  void begin() override { node_.begin(run_); }
  void end(bool output) override {
    if (!output) run_.skip_output();
    node_.end(run_);
  }

 private:
  ctn::AttachedNode node_;
  ctn::Run run_;
};

// A run handles all that is in the inbox: of a subscription whose input is `latest` that is one message, since roscpp
// keeps no more of it.
BoundCallbackOptions options_of(const Binding& binding) {
  BoundCallbackOptions options;
  options.takes_all = true;
  options.runs_by_itself = binding.runs_by_itself;
  options.always_gives_output = binding.always_gives_output || binding.kind == Binding::Kind::kService;
  return options;
}

// Signals are for the program's own threads, as in those that roscpp makes.
class NoSignals {
 public:
  NoSignals() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~NoSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  NoSignals(const NoSignals&) = delete;
  NoSignals& operator=(const NoSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

BoundNode::BoundNode(Binding binding, ros::CallbackQueueInterface& original, FindClient find_client)
    : binding_(std::move(binding)),
      original_(original),
      find_client_(std::move(find_client)),
      turn_(make_turn(original)),
      callback_(options_of(binding_), inbox_, *turn_) {}

BoundNode* BoundNode::current() { return t_node; }

void BoundNode::set_direct_call(std::function<bool()> call) { callback_.set_without_message(std::move(call)); }

// The thread ends with the process at the latest: a callback under way may not return before.
void BoundNode::start() {
  if (std::exchange(started_, true)) return;
  const NoSignals no_signals;
  std::thread([this] { run(); }).detach();
}

void BoundNode::stop() { inbox_.stop(); }

void BoundNode::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) {
  const std::lock_guard lock(bound_mutex_);
  timer_runs_.store(true);
  if (!bound_) {
    original_.addCallback(callback, id);
    return;
  }
  inbox_.put({id, [callback] { return to_outcome(callback->call()); }});
}

void BoundNode::removeByID(std::uint64_t id) {
  timer_runs_.store(false);
  inbox_.remove(id);
  original_.removeByID(id);
}

void BoundNode::note_published(const std::string& topic) {
  if (binding_.gives_output_on(topic)) callback_.note_output();
}

void BoundNode::bind(bool bound) {
  const std::lock_guard lock(bound_mutex_);
  bound_ = bound;
  if (bound) return;
  for (Inbox::Entry& entry : inbox_.take_all()) {
    original_.addCallback(boost::make_shared<HandedOn>(std::move(entry.call)), entry.id);
  }
}

void BoundNode::run() {
  std::optional<ctn::AttachedNode> node = attach();
  if (!node) return;
  ROS_INFO("catan: node %s is scheduled", binding_.node.c_str());
  bind(true);
  t_node = this;
  NodeSchedule schedule(*node);
  callback_.run(schedule);
  t_node = nullptr;
  bind(false);
}

// That there is no server at this moment is no mistake.
std::optional<ctn::AttachedNode> BoundNode::attach() {
  while (!inbox_.stopped()) {
    ctn::Client* const client = find_client_(inbox_.stopped());
    if (client == nullptr) return std::nullopt;
    const ctn::Result<ctn::AttachedNode> attached = client->attach(binding_.node);
    if (attached) return *attached;
    if (attached.error().kind() == ctn::ErrorKind::kCaller) {
      ROS_ERROR("catan: node %s is not scheduled: %s", binding_.node.c_str(), attached.error().message().c_str());
      return std::nullopt;
    }
    std::this_thread::sleep_for(kTryAgain);
  }
  return std::nullopt;
}

}  // namespace catan_ros
