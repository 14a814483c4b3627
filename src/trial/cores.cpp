#include "trial/cores.h"

#include <algorithm>
#include <utility>

namespace ctn::trial {

bool Cores::before(Job one, Job other) const {
  const State& a = jobs_[one];
  const State& b = jobs_[other];
  return a.rank > b.rank || (a.rank == b.rank && a.order < b.order);
}

void Cores::insert(Core& core, Job job) {
  std::vector<Job>& queue = core.queue;
  auto place = queue.end();
  while (place != queue.begin() && !before(job, *(place - 1))) --place;
  queue.insert(place, job);
}

void Cores::remove(Core& core, Job job) {
  if (core.queue.back() == job) return core.queue.pop_back();
  core.queue.erase(std::find(core.queue.begin(), core.queue.end(), job));
}

void Cores::add_work(Job job, int core, Rank rank) {
  State& state = jobs_[job];
  state.core = core;
  state.rank = rank;
  state.used = Nanos{0};
  state.has_work = true;
  state.begun = false;
  state.order = ++last_order_;
  insert(at(core), job);
}

Nanos Cores::used(Job job, TimePoint now) {
  Core& core = at(jobs_[job].core);
  if (core.current == job) account(core, now);
  return jobs_[job].used;
}

void Cores::continue_work(Job job) {
  State& state = jobs_[job];
  Core& core = at(state.core);
  remove(core, job);
  state.begun = false;
  state.order = ++last_order_;
  insert(core, job);
  if (core.current == job) core.current = kNoJob;
}

void Cores::pause(int number) {
  Core& core = at(number);
  jobs_[core.current].away = true;
  remove(core, core.current);
  core.current = kNoJob;
}

void Cores::resume(Job job) {
  State& state = jobs_[job];
  state.away = false;
  state.begun = false;
  state.order = ++last_order_;
  insert(at(state.core), job);
}

void Cores::end_work(int number) {
  Core& core = at(number);
  jobs_[core.current].has_work = false;
  remove(core, core.current);
  core.current = kNoJob;
}

void Cores::change_rank(Job job, Rank rank, TimePoint now) {
  State& state = jobs_[job];
  if (state.rank == rank) return;
  if (state.away) {
    state.rank = rank;
    return;
  }
  Core& core = at(state.core);
  if (core.current == job) account(core, now);
  remove(core, job);
  state.order = rank > state.rank ? ++last_order_ : --first_order_;
  state.rank = rank;
  insert(core, job);
}

void Cores::account(Core& core, TimePoint now) {
  const Nanos used = now - core.since;
  if (used <= Nanos{0}) return;  // held
  core.since = now;
  if (core.current == kNoJob) return;
  State& state = jobs_[core.current];
  state.left -= used;
  state.used += used;
  core.busy += used;
}

void Cores::arm(int number) {
  const Core& core = at(number);
  const State& state = jobs_[core.current];
  timers_.set(static_cast<Timers::Source>(number), core.since + state.left);
}

Job Cores::settle(int number, TimePoint now) {
  Core& core = at(number);
  const Job next = core.queue.empty() ? kNoJob : core.queue.back();
  if (next == core.current) {
    if (next == kNoJob) timers_.set(static_cast<Timers::Source>(number), kNever);
    return kNoJob;
  }
  account(core, now);
  core.current = next;
  if (next == kNoJob) {
    timers_.set(static_cast<Timers::Source>(number), kNever);
    return kNoJob;
  }
  State& state = jobs_[next];
  if (!state.begun && core.held_until > now) {
    core.current = kNoJob;
    timers_.set(static_cast<Timers::Source>(number), core.held_until);
    return kNoJob;
  }
  core.since = std::max(now, core.held_until);
  if (!state.begun) return next;
  state.left += context_switch_;
  arm(number);
  return kNoJob;
}

void Cores::begin(int number, Nanos work) {
  State& state = jobs_[at(number).current];
  state.begun = true;
  state.left = work;
  arm(number);
}

void Cores::hold(int number, TimePoint now, Nanos length) {
  if (length == Nanos{0}) return;
  Core& core = at(number);
  account(core, now);
  core.held_until = std::max(core.held_until, now) + length;
  core.busy += length;
  if (core.current == kNoJob) return;
  core.since = core.held_until;
  arm(number);
}

Cores::Event Cores::account_event(int number, TimePoint now) {
  Core& core = at(number);
  account(core, now);
  return core.current == kNoJob ? Event::kFree : Event::kDone;
}

Nanos Cores::take_busy(int number, TimePoint now) {
  Core& core = at(number);
  account(core, now);
  return std::exchange(core.busy, Nanos{0});
}

}  // namespace ctn::trial
