#include "common/local_loop.h"

#include <thread>
#include <utility>

namespace catan_ros {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{5};

}  // namespace

LocalLoop::LocalLoop(Binding binding, MessageRuns& message_runs, Attach attach)
    : LocalNode(std::move(binding), message_runs), attach_(std::move(attach)) {}

void LocalLoop::try_attach() {
  runs_ = attach_();
  if (std::exchange(tried_, true)) return;
  const auto until = std::chrono::steady_clock::now() + kRegister;
  while (!runs_ && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kBetweenLooks);
    runs_ = attach_();
  }
}

bool LocalLoop::wait() {
  if (!runs_) try_attach();
  const ctn::Awaited awaited = runs_ ? runs_->await() : ctn::Awaited::kIncomplete;
  is_triggered_ = awaited == ctn::Awaited::kTrigger;
  return awaited != ctn::Awaited::kStopped;
}

void LocalLoop::begin() {
  if (!is_triggered_) return;
  output_ = false;
  not_yet_given_ = binding().output_topics;
  LocalNode::begin(*runs_);
}

void LocalLoop::end() {
  if (in_run()) LocalNode::end(output_ || binding().always_gives_output);
}

// So that the server knows that the node lives. A loop that keeps its own time only looks whether it is time yet.
void LocalLoop::skip() {
  if (!is_triggered_ || binding().runs_by_itself) return;
  LocalNode::begin(*runs_);
  LocalNode::end(false);
}

void LocalLoop::note_published(const std::string& topic) {
  if (!binding().gives_output_on(topic)) return;
  output_ = true;
  if (std::erase(not_yet_given_, topic) > 0 && not_yet_given_.empty() && binding().runs_by_itself) end();
}

}  // namespace catan_ros
