// Runs that await input: where a node's program calls it for messages alone, a trigger without one begins nothing yet.
#include <algorithm>
#include <utility>

#include "trial/machine.h"

namespace ctn::trial {

void Machine::add_input(NodeId id) {
  Input& input = inputs_[id.index()].emplace();
  for (const NodeId from : app_.graph.node(id).predecessors) {
    if (app_.graph.node(from).is_external_clock()) input.clocks.push_back(from);
    if (!idlers_[id.index()]) nodes_[from.index()].tells.push_back(id.index());
  }
}

bool Machine::lacks_input(NodeId node) const {
  const std::optional<Input>& input = inputs_[node.index()];
  return input && !input->found && std::none_of(input->clocks.begin(), input->clocks.end(), [&](NodeId clock) {
           return clocks_[clock.index()].last(now_) > input->last_begin;
         });
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
  Input& input = *inputs_[node.index()];
  input.waiting = job;
  if (input.clocks.empty()) return;
  TimePoint tick = kNever;
  for (const NodeId clock : input.clocks) tick = std::min(tick, clocks_[clock.index()].next(now_ + Nanos{1}));
  set_timer(source_of_wait(job), tick, nodes_[node.index()].timers_set);
}

void Machine::begin_with_input(NodeId node) {
  std::optional<Input>& input = inputs_[node.index()];
  if (!input) return;
  input->found = false;
  input->last_begin = now_;
}

// A predecessor has emitted.
void Machine::input_came(NodeId node) {
  std::optional<Input>& input = inputs_[node.index()];
  if (!input) return;
  input->found = true;
  const std::optional<Job> job = std::exchange(input->waiting, std::nullopt);
  if (!job) return;
  timers_.set(source_of_wait(*job), kNever);
  wait_over(*job);
}

}  // namespace ctn::trial
