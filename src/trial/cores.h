// The cores of a trial, and the jobs that compete for them: of those on a core that have work, the one of the highest
// rank has it, and of several of one rank the first. A job that is pre-empted keeps its place. What a job does when it
// gets a core is its owner's business: settle() says when one has to begin.
//
// A job may leave its core under way, to wait: it keeps its rank, and comes back last among those of its rank.
//
// A controller that acts holds its core for some time: what runs there is delayed by as much, and what is to begin
// there begins afterwards, with the inputs that are there by then.
//
// Units: Nanos of CPU time, TimePoint. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/time.h"
#include "trial/timers.h"

namespace ctn::trial {

using Job = std::uint32_t;
constexpr Job kNoJob = std::numeric_limits<Job>::max();

// Of a job: a higher one pre-empts.
using Rank = int;
constexpr Rank kDemoted = 0;
constexpr Rank kAboveAll = std::numeric_limits<Rank>::max();

class Cores {
 public:
  // Core k's next event is that of source k of `timers`, which outlives it. `context_switch`: CPU time of a job that
  // gets a core back.
  Cores(std::size_t cores, std::size_t jobs, Nanos context_switch, Timers& timers)
      : context_switch_(context_switch), timers_(timers), cores_(cores), jobs_(jobs) {
    for (Core& core : cores_) core.queue.reserve(jobs);
  }

  int count() const { return static_cast<int>(cores_.size()); }
  bool idle(int core) const { return at(core).queue.empty(); }
  bool has_work(Job job) const { return jobs_[job].has_work; }  // waiting or not
  int core_of(Job job) const { return jobs_[job].core; }
  Job current(int core) const { return at(core).current; }
  Rank rank_of(Job job) const { return jobs_[job].rank; }  // of its newest work
  Rank rank_on(int core) const { return idle(core) ? -1 : jobs_[at(core).queue.back()].rank; }

  // It has work from now on, last among those of its rank.
  void add_work(Job job, int core, Rank rank);
  // CPU time that it has used since then.
  Nanos used(Job job, TimePoint now);
  // The same run goes on with something else, to begin when the job has the core: last among those of its rank.
  void continue_work(Job job);
  // The current job of the core waits, until it comes back with something else to begin.
  void pause(int core);
  void resume(Job job);
  // The current job of the core has no work any more.
  void end_work(int core);
  // A job that is raised comes last in its new rank, one that is lowered first. Precondition: it has work.
  void change_rank(Job job, Rank rank, TimePoint now);

  // Gives the core to the job that it belongs to. The job that has got it and has to begin, for which the caller calls
  // begin(). kNoJob: there is nothing more to do.
  Job settle(int core, TimePoint now);
  // The core's current job needs so much CPU time.
  void begin(int core, Nanos work);
  // A controller acts on the core.
  void hold(int core, TimePoint now, Nanos length);

  // The core's event is due; what has been used until now is accounted for.
  enum class Event {
    kFree,  // no controller holds it any more
    kDone,  // its job has had what it needed
  };
  Event account_event(int core, TimePoint now);

  // CPU time that was used in [the last call, now].
  Nanos take_busy(int core, TimePoint now);

 private:
  struct Core {
    Job current = kNoJob;
    TimePoint since{};       // accounted for up to here
    TimePoint held_until{};  // by controllers
    Nanos busy{0};
    std::vector<Job> queue;  // those that have work, the current one included; the next at the back
  };
  struct State {
    int core = 0;
    Rank rank = 0;
    std::int64_t order = 0;  // within its rank: the lowest first
    Nanos left{0};
    Nanos used{0};
    bool has_work = false;
    bool begun = false;
    bool away = false;  // it waits
  };

  Core& at(int core) { return cores_[static_cast<std::size_t>(core)]; }
  const Core& at(int core) const { return cores_[static_cast<std::size_t>(core)]; }

  bool before(Job one, Job other) const;
  void insert(Core& core, Job job);
  void remove(Core& core, Job job);
  void account(Core& core, TimePoint now);
  void arm(int number);

  Nanos context_switch_;
  Timers& timers_;
  std::vector<Core> cores_;
  std::vector<State> jobs_;
  std::int64_t first_order_ = 0;
  std::int64_t last_order_ = 0;
};

}  // namespace ctn::trial
