#include "common/local_node.h"

namespace catan_ros {
namespace {

thread_local LocalNode* t_local_node = nullptr;

}  // namespace

LocalNode* LocalNode::current() { return t_local_node; }

void LocalNode::note_sent(MessageRuns::Key key) {
  if (message_runs_ != nullptr) message_runs_->note(binding_.node, key, runs_->number());
}

void LocalNode::note_taken(MessageRuns::Key key) {
  if (message_runs_ == nullptr) return;
  for (const std::string& predecessor : binding_.predecessors) {
    if (const std::uint64_t run = message_runs_->find(predecessor, key); run != 0) note_taken_from(predecessor, run);
  }
}

void LocalNode::note_taken_from(const std::string& predecessor, std::uint64_t run) {
  runs_->take(predecessor, run);
  kept_[predecessor] = run;
}

void LocalNode::begin(Runs& runs) {
  runs.begin();
  runs_ = &runs;
  for (const auto& [from, run] : kept_) runs.keep(from, run);
  t_local_node = this;
}

void LocalNode::end(bool output) {
  t_local_node = nullptr;
  if (output) kept_.clear();
  std::exchange(runs_, nullptr)->end(output);
}

}  // namespace catan_ros
