#include "ros1/bound_node.h"

#include <ros/console.h>
#include <ros/this_node.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <iterator>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <boost/make_shared.hpp>

#include "common/asked_callbacks.h"
#include "ros1/nodelet_hooks.h"
#include "ros1/thrown.h"
#include "ros1/turns_of_queues.h"

namespace catan_ros {
namespace {

// After which a message should have come.
constexpr std::chrono::seconds kFirstMessage{10};
// For a server that is there, before the program goes on without.
constexpr std::chrono::milliseconds kRegister{500};

thread_local BoundNode* t_node = nullptr;

// A run handles all that is in the inbox, or the newest message of a subscription whose input is `latest`.
BoundCallbackOptions options_of(const Binding& binding) {
  BoundCallbackOptions options;
  options.takes_newest = binding.kind == Binding::Kind::kTopic && !binding.takes_all;
  options.takes_all = !options.takes_newest;
  options.runs_by_itself = binding.runs_by_itself;
  options.always_gives_output = binding.gives_output_unseen();
  // Nobody may ask for it at all, and the nodes before it are not to wait for that.
  if (binding.kind == Binding::Kind::kService && binding.is_behind) options.patience = std::chrono::nanoseconds{0};
  return options;
}

// What is under way when the callback is removed: of a subscription roscpp waits for that, of a timer or a service it
// does not (from 1.15.10 on), and who removes them may have got what the call waits for.
Inbox::UnderWay under_way_of(const Binding& binding) {
  return binding.kind == Binding::Kind::kTopic ? Inbox::UnderWay::kIsWaitedFor : Inbox::UnderWay::kGoesOn;
}

// What the node gives to others of its program, it gives them without a message: each run does. By the time of its
// first run a program has advertised what it publishes.
bool goes_through_memory(const Binding& binding) {
  if (!binding.feeds_own_program) return false;
  ros::V_string advertised;
  ros::this_node::getAdvertisedTopics(advertised);
  return std::none_of(binding.output_topics.begin(), binding.output_topics.end(), [&](const std::string& topic) {
    return std::find(advertised.begin(), advertised.end(), topic) != advertised.end();
  });
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

// A call that the program's own queue makes; unless its node is bound by then, whose runs are to make it.
class BoundNode::PassedOn final : public ros::CallbackInterface {
 public:
  PassedOn(BoundNode& node, const Candidate* from, std::function<Outcome()> call, std::uint64_t id)
      : node_(node), from_(from), call_(std::move(call)), id_(id) {}
  CallResult call() override {
    switch (node_.call_passed_on(from_, call_, id_)) {
      case Outcome::kCalled:
        return Success;
      case Outcome::kAgain:
        return TryAgain;
      case Outcome::kNothing:
        break;
    }
    return Invalid;
  }

 private:
  BoundNode& node_;
  const Candidate* const from_;  // maybe gone
  std::function<Outcome()> call_;
  const std::uint64_t id_;
};

// It looks what the program has got when a run begins.
class BoundNode::NotingRuns final : public Schedule {
 public:
  NotingRuns(NodeRuns& runs, BoundNode& owner) : runs_(runs), owner_(owner) {}
  ctn::Awaited await() override { return runs_.await(); }
  bool await_complete() override { return runs_.await_complete(); }
  void begin() override {
    runs_.begin();
    owner_.note_begun();
  }
  void end(bool output) override { runs_.end(output); }

 private:
  NodeRuns& runs_;
  BoundNode& owner_;
};

std::string describe(const Binding& binding) {
  switch (binding.kind) {
    case Binding::Kind::kTopic:
      return "a subscription of " + binding.name;
    case Binding::Kind::kService:
      return "a service " + binding.name;
    case Binding::Kind::kTimer:
    case Binding::Kind::kLoop:
      break;
  }
  return "a timer of " + period_text(binding.period);
}

BoundNode::BoundNode(Binding binding, MessageRuns* message_runs, const KeptMessages& kept, ServerConnection& connection)
    : binding_(std::move(binding)),
      message_runs_(message_runs),
      kept_(kept),
      connection_(connection),
      callback_(options_of(binding_), inbox_, turn_) {
  const bool is_triggered_timer = binding_.kind == Binding::Kind::kTimer && !binding_.runs_by_itself;
  if (is_triggered_timer) callback_.set_without_message([this] { return call_directly(); });
  if (message_runs_ != nullptr && !binding_.predecessors.empty()) {
    callback_.set_newest_sent([this] { return newest_sent(); });
  }
  callback_.set_after_call([this] { wake_loop(); });
  callback_.set_let_go([this] { bind(false); }, [this] { take_back(); });
}

BoundNode* BoundNode::current() { return t_node; }

BoundNode::Candidate::Candidate(BoundNode& node, ros::CallbackQueueInterface& original)
    : node_(node), original_(original) {
  const std::lock_guard lock(node_.bound_mutex_);
  node_.join(*this);
}

BoundNode::Candidate::~Candidate() {
  const std::lock_guard lock(node_.bound_mutex_);
  node_.leave(*this);
}

void BoundNode::Candidate::set_direct_call(std::function<bool()> call, bool timer_runs) {
  const std::lock_guard lock(node_.bound_mutex_);
  direct_call_ = std::make_shared<std::function<bool()>>(handing_on_exceptions(std::move(call), original_));
  timer_runs_ = timer_runs;
}

void BoundNode::Candidate::addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) {
  node_.put(*this, callback, id);
}

void BoundNode::Candidate::removeByID(std::uint64_t id) { node_.remove(*this, id); }

std::shared_ptr<BoundNode::Candidate> BoundNode::add_candidate(ros::CallbackQueueInterface& original) {
  return std::make_shared<Candidate>(*this, original);
}

// Precondition: bound_mutex_ is held. It is called anew where the program starts a timer again that it has stopped.
void BoundNode::join(Candidate& candidate) {
  if (std::find(candidates_.begin(), candidates_.end(), &candidate) != candidates_.end()) return;
  candidates_.push_back(&candidate);
  if (candidates_.size() > 1) return;
  give_node_to_first();
  inbox_.expect_calls(true);
}

// Precondition: bound_mutex_ is held. A program that has unsubscribed, as one does to whose output nobody listens, may
// subscribe again: until then nothing comes, and triggers are not to wait for it.
void BoundNode::leave(const Candidate& candidate) {
  const auto found = std::find(candidates_.begin(), candidates_.end(), &candidate);
  if (found == candidates_.end()) return;
  const bool had_node = found == candidates_.begin();
  candidates_.erase(found);
  if (candidates_.empty()) {
    inbox_.expect_calls(false);
  } else if (had_node) {
    give_node_to_first();
  }
}

// Precondition: bound_mutex_ is held, and there is a candidate. A run that has begun with the turn of a queue makes no
// calls of another queue's callbacks, which would overlap with others of that queue: until it ends these are called as
// if they waited.
bool BoundNode::has_node(const Candidate* candidate) const {
  return candidates_.front() == candidate && turn_.is_current();
}

// Precondition: bound_mutex_ is held.
bool BoundNode::is_being_removed(std::uint64_t id) const {
  return std::find(being_removed_.begin(), being_removed_.end(), id) != being_removed_.end();
}

// Precondition: bound_mutex_ is held.
void BoundNode::give_node_to_first() {
  ros::CallbackQueueInterface& queue = candidates_.front()->original_;
  if (std::exchange(queue_of_turn_, &queue) == &queue) return;
  turn_.set(make_turn(queue));
  turns_of_queue_.store(turns_of(queue));
}

// As long as there is a candidate, the program has not given up its queue.
void BoundNode::wake_loop() {
  const TurnsOfQueue* const turns = turns_of_queue_.load();
  if (turns == nullptr || !turns->has_waiting_loop()) return;
  const std::lock_guard lock(bound_mutex_);
  if (candidates_.empty()) return;
  if (TurnsOfQueue* const now = turns_of_queue_.load()) now->wake_loop(candidates_.front()->original_);
}

void BoundNode::put(Candidate& from, const ros::CallbackInterfacePtr& callback, std::uint64_t id) {
  {
    const std::lock_guard lock(bound_mutex_);
    if (from.is_given_up_) return from.original_.addCallback(callback, id);
    from.timer_runs_ = true;
    join(from);
    if (has_node(&from) && bound_) {
      inbox_.put({id, handing_on_exceptions(callback, from.original_)});
      if (!from.keeps_all_.load()) callback_.let_go_of_older();
      return;
    }
    if (candidates_.front() == &from) return pass_on(from, handing_on_exceptions(callback, from.original_), id);
    from.original_.addCallback(callback, id);
    if (std::exchange(from.is_told_of_, true)) return;
  }
  tell_of_waiting(from);
}

void BoundNode::remove(Candidate& from, std::uint64_t id) {
  {
    const std::lock_guard lock(bound_mutex_);
    from.timer_runs_ = false;
    being_removed_.push_back(id);
  }
  inbox_.remove(id, under_way_of(binding_));
  from.original_.removeByID(id);
  const std::lock_guard lock(bound_mutex_);
  being_removed_.erase(std::find(being_removed_.begin(), being_removed_.end(), id));
  leave(from);
}

// Precondition: bound_mutex_ is held.
void BoundNode::pass_on(Candidate& from, std::function<Outcome()> call, std::uint64_t id) {
  from.original_.addCallback(boost::make_shared<PassedOn>(*this, &from, std::move(call), id), id);
}

// Once ROS shuts down, roscpp's queue calls nothing more. It says so to us a little earlier than to that queue.
Outcome BoundNode::call_passed_on(const Candidate* from, std::function<Outcome()>& call, std::uint64_t id) {
  if (inbox_.stopped()) return Outcome::kNothing;
  {
    const std::lock_guard lock(bound_mutex_);
    if (bound_ && !candidates_.empty() && has_node(from) && !is_being_removed(id)) {
      inbox_.put({id, std::move(call)});
      return Outcome::kCalled;
    }
    unbound_.begin();
  }
  const UnboundCalls::Ended at_end(unbound_);
  return call();
}

// What was to be called is let go without the mutex.
void BoundNode::give_up(const ros::CallbackQueueInterface* queue) {
  std::deque<Inbox::Entry> dropped;
  {
    const std::lock_guard lock(bound_mutex_);
    std::vector<Candidate*> gone;
    std::copy_if(candidates_.begin(), candidates_.end(), std::back_inserter(gone),
                 [&](const Candidate* one) { return &one->original_ == queue; });
    if (gone.empty()) return;
    if (gone.front() == candidates_.front()) dropped = inbox_.take_all();
    for (Candidate* const one : gone) {
      one->is_given_up_ = true;
      leave(*one);
    }
  }
  inbox_.wait_for_call();
}

// Of one that is called while it waits, and does not just wait for the one before to go.
void BoundNode::tell_of_waiting(const Candidate& candidate) const {
  const std::string nodelet = binding_.nodelet.empty() ? nodelet_of(candidate.original_) : std::string();
  const std::string hint = nodelet.empty() ? "" : " (it is of nodelet " + nodelet + ": a binding may name one)";
  ROS_WARN(
      "catan: there is another callback of %s; the first one is node %s as long as it is there, the other is not "
      "scheduled%s",
      describe(binding_).c_str(), binding_.node.c_str(), hint.c_str());
}

bool BoundNode::call_directly() {
  std::shared_ptr<std::function<bool()>> call;
  {
    const std::lock_guard lock(bound_mutex_);
    if (candidates_.empty()) return false;
    const Candidate& first = *candidates_.front();
    if (has_node(&first) && first.timer_runs_) call = first.direct_call_;
  }
  return call != nullptr && (*call)();
}

// The thread ends with the process at the latest: a callback under way may not return before.
void BoundNode::start() {
  if (started_.exchange(true)) return;
  {
    const NoSignals no_signals;
    std::thread([this] { run(); }).detach();
  }
  const std::lock_guard lock(bound_mutex_);
  const auto until = std::chrono::steady_clock::now() + kRegister;
  while (!settled_ && settled_changed_.wait_until(bound_mutex_, until)) {
  }
}

void BoundNode::stop() { inbox_.stop(); }

void BoundNode::note_begun() {
  if (!has_begun_) {
    has_begun_ = true;
    first_run_ = std::chrono::steady_clock::now();
    if (goes_through_memory(binding_)) callback_.set_always_gives_output();
  }
  tell_of_no_message();
  // Where it takes all that has come since the run before, that may be nothing.
  if (message_runs_ == nullptr || binding_.predecessors.empty() || binding_.takes_all) return;
  const std::vector<MessageRuns::Key> keys = kept_.keys();
  for (const std::string& predecessor : binding_.predecessors) {
    std::uint64_t newest = 0;
    for (const MessageRuns::Key key : keys) newest = std::max(newest, message_runs_->find(predecessor, key));
    if (newest != 0) runs_->keep(predecessor, newest);
  }
}

// Of a topic that is misspelt, or of another type, ROS gives nothing.
void BoundNode::tell_of_no_message() {
  if (binding_.kind != Binding::Kind::kTopic || has_message_ || told_of_none_) return;
  if (std::chrono::steady_clock::now() - first_run_ < kFirstMessage) return;
  told_of_none_ = true;
  ROS_WARN(
      "catan: node %s is triggered, and no message has come on %s in %d s: see rostopic info %s for who publishes "
      "it, and whether with the type that %s takes",
      binding_.node.c_str(), binding_.name.c_str(), static_cast<int>(kFirstMessage.count()), binding_.name.c_str(),
      binding_.ros_node.c_str());
}

std::optional<MessageRuns::Time> BoundNode::newest_sent() const {
  std::optional<MessageRuns::Time> newest;
  for (const std::string& predecessor : binding_.predecessors) {
    newest = std::max(newest, message_runs_->last_time(predecessor, binding_.name));
  }
  return newest;
}

void BoundNode::note_sending(const std::string& topic) {
  if (message_runs_ != nullptr) message_runs_->note_time(binding_.node, topic, std::chrono::steady_clock::now());
}

void BoundNode::note_published(const std::string& topic) {
  if (binding_.gives_output_on(topic) || is_taken_by_successor(topic)) callback_.note_output();
}

bool BoundNode::is_taken_by_successor(const std::string& topic) const {
  return message_runs_ != nullptr &&
         std::any_of(binding_.successors.begin(), binding_.successors.end(),
                     [&](const std::string& successor) { return message_runs_->subscribes(successor, topic); });
}

void BoundNode::note_sent(MessageRuns::Key key) {
  if (message_runs_ != nullptr) message_runs_->note(binding_.node, key, runs_->number());
}

void BoundNode::note_taken(MessageRuns::Key key) {
  note_message();
  if (message_runs_ == nullptr) return;
  for (const std::string& predecessor : binding_.predecessors) {
    const std::uint64_t run = message_runs_->find(predecessor, key);
    if (run != 0) runs_->take(predecessor, run);
  }
}

// Messages that were kept, as a synchronizer does: of those that it lets go of in a run the newest are those it used.
void BoundNode::note_let_go(MessageRuns::Key key) {
  for (const std::string& predecessor : binding_.predecessors) {
    const std::uint64_t run = message_runs_ != nullptr ? message_runs_->find(predecessor, key) : 0;
    if (run != 0) runs_->let_go(predecessor, run);
  }
}

// What is being removed is let go without the mutex.
void BoundNode::bind(bool bound) {
  std::vector<Inbox::Entry> removed;
  const std::lock_guard lock(bound_mutex_);
  bound_ = bound;
  settled_ = true;
  settled_changed_.notify_all();
  // Without a candidate there is nothing: what was removed is not there.
  if (bound || candidates_.empty()) return;
  for (Inbox::Entry& entry : inbox_.take_all()) {
    if (is_being_removed(entry.id)) {
      removed.push_back(std::move(entry));
    } else {
      pass_on(*candidates_.front(), std::move(entry.call), entry.id);
    }
  }
}

void BoundNode::take_back() {
  bind(true);
  unbound_.wait_for_ends(inbox_.stopped());
}

void BoundNode::run() {
  const std::optional<ctn::AttachedNode> node =
      connection_.attach(binding_.node, inbox_.stopped(), [this] { bind(false); });
  if (!node) return bind(false);
  ROS_INFO("catan: node %s is scheduled", binding_.node.c_str());
  take_back();
  t_node = this;
  NodeRuns runs(*node);
  runs_ = &runs;
  NotingRuns schedule(runs, *this);
  callback_.run(schedule);
  runs_ = nullptr;
  t_node = nullptr;
  bind(false);
}

}  // namespace catan_ros
