#include <algorithm>
#include <cmath>

#include "trial/machine.h"

namespace ctn::trial {

void Machine::add_pipelines() {
  pipe_of_core_.resize(static_cast<std::size_t>(schedule_.cores));
  pipe_of_subchain_.resize(schedule_.subchains.size());
  for (const Pipeline& pipeline : schedule_.pipelines) {
    const std::size_t number = pipes_.size();
    Pipe& pipe = pipes_.emplace_back(
        Pipe{.subchain = pipeline.subchain.index(), .pipeline = &pipeline, .stages = {}, .waiting = {}});
    pipe_of_subchain_[pipe.subchain] = number;
    subchains_[pipe.subchain].trigger.emplace(TimePoint{}, pipeline.pacing);
    for (const int core : pipeline.cores) pipe_of_core_[static_cast<std::size_t>(core)] = number;
    for (const NodeId node : app_.graph.subchain(pipeline.subchain).nodes) {
      const std::size_t stage = pipe.stages.size();
      pipe.stages.push_back(
          {.node = node, .first_thread = first_pipe_thread() + static_cast<Job>(pipe_threads_.size())});
      for (int thread = 0; thread < std::max(pipeline.threads, 1); ++thread) {
        pipe_threads_.push_back({number, stage, thread > 0});
      }
    }
  }
}

// A node that is at work takes the newest trigger that has come meanwhile afterwards, and no other.
void Machine::wake(Pipe& pipe, std::size_t number, std::uint64_t token) {
  Stage& stage = pipe.stages[number];
  stage.word = token;
  if (stage.busy) return;
  stage.busy = true;
  queue_run(pipe, stage);
}

// Once there is input, where its node awaits that.
void Machine::queue_run(Pipe& pipe, const Stage& stage) {
  lacks_input(stage.node) ? await_input(stage.first_thread) : queue_for_core(pipe, stage.first_thread);
}

// First come, first served.
void Machine::queue_for_core(Pipe& pipe, Job job) {
  const std::vector<int>& cores = pipe.pipeline->cores;
  const auto idle = std::find_if(cores.begin(), cores.end(), [&](int core) { return cores_.idle(core); });
  if (idle == cores.end() || !pipe.waiting.empty()) return pipe.waiting.push_back(job);
  cores_.add_work(job, *idle, 1);
  touch(*idle);
}

// A thread that waits for a core of the pipeline takes this one, if it is free.
void Machine::take_waiting(int core) {
  const std::optional<std::size_t> number = pipe_of_core_[static_cast<std::size_t>(core)];
  if (!number || !cores_.idle(core)) return;
  Pipe& pipe = pipes_[*number];
  if (pipe.waiting.empty()) return;
  cores_.add_work(pipe.waiting.front(), core, 1);
  pipe.waiting.pop_front();
}

// A run begins on the node's first thread, which wakes those that help.
Nanos Machine::begin_pipe_thread(const PipeThread& thread, int core) {
  Pipe& pipe = pipes_[thread.pipe];
  Stage& stage = pipe.stages[thread.stage];
  if (thread.helper) return stage.share;
  if (nodes_[stage.node.index()].rest > Nanos{0}) return rest_of_run(stage.node);
  stage.token = stage.word;
  const Samples::Split split =
      samples_.split(stage.node, kind_of_core_[static_cast<std::size_t>(core)], pipe.pipeline->threads);
  const Nanos overhead = options_.overheads.run + options_.overheads.context_switch;
  const Nanos alone = begin_run(stage.node, core) - overhead;
  stage.share = Nanos{std::llround(static_cast<double>(alone.count()) * split.part)} + overhead;
  stage.working = std::min(split.threads, std::max(pipe.pipeline->threads, 1));
  for (Job helper = 1; helper < static_cast<Job>(stage.working); ++helper)
    queue_for_core(pipe, stage.first_thread + helper);
  return until_wait(stage.node, stage.share);
}

void Machine::pipe_thread_ended(const PipeThread& thread, int core) {
  Pipe& pipe = pipes_[thread.pipe];
  Stage& stage = pipe.stages[thread.stage];
  cores_.end_work(core);
  if (--stage.working > 0) return;  // the thread that works longest ends the run
  const bool emits = end_run(stage.node);
  if (emits && thread.stage + 1 < pipe.stages.size()) {
    wake(pipe, thread.stage + 1, stage.token);
  } else {
    Subchain& subchain = subchains_[pipe.subchain];
    count_run(subchain);
    subchain.completed = std::max(subchain.completed, stage.token);
    if (emits) hear_output(subchain.followers);
    if (subchain.awaits_completion) pace(subchain, WokenBy::kEvent);
  }
  stage.busy = stage.word != stage.token;
  if (stage.busy) queue_run(pipe, stage);
}

}  // namespace ctn::trial
