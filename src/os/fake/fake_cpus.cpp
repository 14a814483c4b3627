#include "os/fake/fake_cpus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <tuple>

namespace ctn::os {

// --- Claims ---

void FakeCpus::add(ThreadId thread, Level level, const CpuSet& usable) {
  assert(!has(thread) && !usable.empty());
  Claim& claim = claims_[thread];
  claim.thread = thread;
  claim.level = level;
  claim.usable = usable;
  claim.place = ++end_;
}

void FakeCpus::remove(ThreadId thread) { claims_.erase(thread); }

std::optional<int> FakeCpus::cpu_of(ThreadId thread) const {
  const auto claim = claims_.find(thread);
  if (claim != claims_.end() && claim->second.cpu) return claim->second.cpu;
  const auto last = last_cpu_.find(thread);
  return last != last_cpu_.end() ? std::optional(last->second) : std::nullopt;
}

void FakeCpus::consume(ThreadId thread, Nanos cpu_time) { claims_.at(thread).left = cpu_time; }

void FakeCpus::requeue(Claim& claim, std::int64_t place) {
  claim.place = place;
  claim.slice = kSlice;
  claim.cpu.reset();
}

void FakeCpus::to_the_end(ThreadId thread) { requeue(claims_.at(thread), ++end_); }

void FakeCpus::set_level(ThreadId thread, Level level) {
  const auto found = claims_.find(thread);
  if (found == claims_.end() || found->second.level == level) return;
  const bool to_front = level < found->second.level && level != Level::kOrdinary;
  found->second.level = level;
  requeue(found->second, to_front ? --front_ : ++end_);
}

void FakeCpus::set_usable(ThreadId thread, const CpuSet& usable) {
  const auto found = claims_.find(thread);
  if (found == claims_.end()) return;
  Claim& claim = found->second;
  const CpuSet before = std::exchange(claim.usable, usable);
  if (claim.cpu && usable.contains(*claim.cpu)) return;
  const auto lost = [&](int cpu) { return !usable.contains(cpu); };
  if (std::any_of(before.cpus().begin(), before.cpus().end(), lost)) to_the_end(thread);
}

// --- Which thread gets which CPU ---

FakeCpus::Claim* FakeCpus::holder(int cpu) {
  for (auto& [thread, claim] : claims_) {
    if (claim.cpu == cpu) return &claim;
  }
  return nullptr;
}

std::optional<int> FakeCpus::free_cpu(const Claim& claim) {
  const auto last = last_cpu_.find(claim.thread);
  if (last != last_cpu_.end() && claim.usable.contains(last->second) && !holder(last->second)) return last->second;
  for (const int cpu : claim.usable.cpus()) {
    if (!holder(cpu)) return cpu;
  }
  return std::nullopt;
}

// Precondition: none of the CPUs that the claim can use is free.
FakeCpus::Claim* FakeCpus::lowest_holder(const Claim& claim) {
  const auto rank = [](const Claim& candidate) { return std::tuple(candidate.level, -candidate.place); };
  Claim* lowest = nullptr;
  for (const int cpu : claim.usable.cpus()) {
    Claim* const candidate = holder(cpu);
    if (!lowest || rank(*candidate) < rank(*lowest)) lowest = candidate;
  }
  return lowest;
}

bool FakeCpus::place(Claim& claim) {
  claim.cpu = free_cpu(claim);
  if (!claim.cpu) {
    Claim* const lowest = lowest_holder(claim);
    if (lowest->level >= claim.level) return false;
    claim.cpu = std::exchange(lowest->cpu, std::nullopt);
  }
  last_cpu_[claim.thread] = *claim.cpu;
  return true;
}

std::vector<FakeCpus::Claim*> FakeCpus::waiting_in_line() {
  std::vector<Claim*> line;
  for (auto& [thread, claim] : claims_) {
    if (!claim.cpu) line.push_back(&claim);
  }
  const auto rank = [](const Claim* claim) { return std::tuple(-static_cast<int>(claim->level), claim->place); };
  std::sort(line.begin(), line.end(), [&](const Claim* a, const Claim* b) { return rank(a) < rank(b); });
  return line;
}

void FakeCpus::assign() {
  std::vector<Claim*> spent;
  for (auto& [thread, claim] : claims_) {
    if (claim.cpu && claim.spent()) spent.push_back(&claim);
  }
  std::sort(spent.begin(), spent.end(), [](const Claim* a, const Claim* b) { return a->place < b->place; });
  for (Claim* const claim : spent) requeue(*claim, ++end_);

  // A thread that is placed may have put another one out: the line is new each time. It ends, because each step fills a
  // CPU or raises the level on one.
  const auto place_first = [&] {
    const std::vector<Claim*> line = waiting_in_line();
    return std::any_of(line.begin(), line.end(), [&](Claim* claim) { return place(*claim); });
  };
  while (place_first()) continue;
}

// --- Time ---

std::optional<ThreadId> FakeCpus::ready() const {
  const auto rank = [](const Claim& claim) { return std::tuple(-static_cast<int>(claim.level), claim.place); };
  const Claim* first = nullptr;
  for (const auto& [thread, claim] : claims_) {
    if (!claim.cpu || claim.left > Nanos{0}) continue;
    if (!first || rank(claim) < rank(*first)) first = &claim;
  }
  return first ? std::optional(first->thread) : std::nullopt;
}

std::optional<Nanos> FakeCpus::next_event() const {
  std::optional<Nanos> next;
  for (const auto& [thread, claim] : claims_) {
    if (!claim.cpu) continue;
    const Nanos until = claim.level == Level::kOrdinary ? std::min(claim.left, claim.slice) : claim.left;
    next = std::min(next.value_or(until), until);
  }
  return next;
}

std::vector<ThreadId> FakeCpus::waiting() const {
  std::vector<ThreadId> waiting;
  for (const auto& [thread, claim] : claims_) {
    if (!claim.cpu) waiting.push_back(thread);
  }
  return waiting;
}

std::vector<ThreadId> FakeCpus::pass(TimePoint now, Nanos duration) {
  std::map<int, Claim*> busy;
  for (auto& [thread, claim] : claims_) {
    if (claim.cpu) busy[*claim.cpu] = &claim;
  }
  std::vector<ThreadId> served;
  for (const auto& [cpu, claim] : busy) {
    assert(duration <= claim->left);
    claim->left -= duration;
    claim->slice -= duration;
    record(*claim, now, now + duration);
    served.push_back(claim->thread);
  }
  return served;
}

void FakeCpus::record(const Claim& claim, TimePoint begin, TimePoint end) {
  const auto [last, first_on_cpu] = last_stretch_.try_emplace(*claim.cpu, stretches_.size());
  if (!first_on_cpu) {
    Stretch& stretch = stretches_[last->second];
    if (stretch.thread == claim.thread && stretch.level == claim.level && stretch.end == begin) {
      stretch.end = end;
      return;
    }
  }
  last->second = stretches_.size();
  stretches_.push_back({*claim.cpu, claim.thread, claim.level, begin, end});
}

std::string FakeCpus::describe(ThreadId thread) const {
  const auto found = claims_.find(thread);
  if (found == claims_.end()) return "";
  const Claim& claim = found->second;
  const auto where = claim.cpu ? fmt::format("has CPU {}", *claim.cpu)
                               : fmt::format("waits for one of CPUs {}", to_string(claim.usable));
  return fmt::format("{}, {:.6f} ms to go", where, to_millis(claim.left).count());
}

}  // namespace ctn::os
