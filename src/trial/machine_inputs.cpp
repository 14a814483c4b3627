// Runs that await input: where a node's program calls it for messages alone, a trigger without one begins nothing yet.
#include <utility>

#include "trial/machine.h"

namespace ctn::trial {

bool Machine::lacks_input(NodeId node) const {
  return inputs_[node.index()] && !news_[node.index()]->any(now_, clocks_);
}

// Whether what the job is to begin is a run that lacks input. Pipelines ask before they wait for a core.
bool Machine::lacks_input(Job job) const {
  if (job >= first_pipe_thread()) return false;
  const NodeId node = node_of(job);
  return nodes_[node.index()].rest == Nanos{0} && lacks_input(node);
}

// The job is away, until input_came() or the next tick of a clock that feeds its node.
void Machine::await_input(Job job) {
  const NodeId node = node_of(job);
  inputs_[node.index()]->waiting = job;
  const TimePoint tick = news_[node.index()]->next_tick(now_, clocks_);
  if (tick != kNever) set_timer(source_of_wait(job), tick, nodes_[node.index()].timers_set);
}

// A predecessor has emitted: the run that waits for that, if there is one, goes on.
void Machine::input_came(NodeId node) {
  std::optional<Input>& input = inputs_[node.index()];
  if (!input) return;
  const std::optional<Job> job = std::exchange(input->waiting, std::nullopt);
  if (!job) return;
  timers_.set(source_of_wait(*job), kNever);
  wait_over(*job);
}

}  // namespace ctn::trial
