// Exclusive groups: one run of their nodes at a time, as callbacks of a spinner or users of a mutex with priority
// inheritance.
#include <algorithm>

#include "trial/machine.h"

namespace ctn::trial {

// Null: the job's node is in none.
Machine::Exclusion* Machine::exclusion_of(Job job) {
  if (exclusions_.empty() || job >= first_pipe_thread()) return nullptr;
  const std::optional<std::size_t> exclusion = app_.graph.node(node_of(job)).exclusive;
  return exclusion ? &exclusions_[*exclusion] : nullptr;
}

// Before a run begins or goes on. False: it is to wait until the exclusive group is its own.
bool Machine::enter(Job job) {
  Exclusion* const exclusion = exclusion_of(job);
  if (exclusion == nullptr || exclusion->holder == job) return true;
  if (!exclusion->holder) {
    exclusion->holder = job;
    exclusion->own = cores_.rank_of(job);
    raise_holder(*exclusion);
    return true;
  }
  exclusion->waiting.push_back(job);
  raise_holder(*exclusion);
  return false;
}

// A run of the node has ended.
void Machine::leave(NodeId node) {
  const std::optional<std::size_t> group = app_.graph.node(node).exclusive;
  if (!group) return;
  Exclusion& exclusion = exclusions_[*group];
  if (!exclusion.holder || node_of(*exclusion.holder) != node) return;
  const Job before = *exclusion.holder;
  cores_.change_rank(before, exclusion.own, now_);
  touch(cores_.core_of(before));
  exclusion.holder.reset();
  const auto next = std::max_element(exclusion.waiting.begin(), exclusion.waiting.end(),
                                     [&](Job a, Job b) { return cores_.rank_of(a) < cores_.rank_of(b); });
  if (next == exclusion.waiting.end()) return;
  // It asks again when it has its core: a higher one may be first.
  const Job chosen = *next;
  exclusion.waiting.erase(next);
  cores_.resume(chosen);
  touch(cores_.core_of(chosen));
}

// Its own, from now on; it has a higher one for as long as that waits for it.
void Machine::set_rank(Job job, Rank rank) {
  Exclusion* const exclusion = exclusion_of(job);
  const bool holds = exclusion != nullptr && exclusion->holder == job;
  if (!holds) cores_.change_rank(job, rank, now_);
  if (exclusion == nullptr || !exclusion->holder) return;
  if (holds) exclusion->own = rank;
  raise_holder(*exclusion);
}

void Machine::raise_holder(const Exclusion& exclusion) {
  Rank rank = exclusion.own;
  for (const Job waiting : exclusion.waiting) rank = std::max(rank, cores_.rank_of(waiting));
  cores_.change_rank(*exclusion.holder, rank, now_);
  touch(cores_.core_of(*exclusion.holder));
}

}  // namespace ctn::trial
