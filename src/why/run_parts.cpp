#include "why/run_parts.h"

#include <algorithm>
#include <utility>

namespace ctn::why {
namespace {

Nanos overlap_of(const RunTimes& run, Span span) {
  return std::max(std::min(run.end, span.end) - std::max(run.begin, span.begin), Nanos{0});
}

// The CPU time that a run used in a span, taking its use to be even.
Nanos used_in(const RunTimes& run, Span span) {
  const Nanos wall = run.end - run.begin;
  const Nanos shared = overlap_of(run, span);
  if (shared >= wall || wall <= Nanos{0}) return std::min(run.cpu, shared);
  const double part = static_cast<double>(shared.count()) / static_cast<double>(wall.count());
  return std::min(Nanos{static_cast<Nanos::rep>(part * static_cast<double>(run.cpu.count()))}, shared);
}

// What kept the run from its core, `not_running` in all, by begin. Less if no other run accounts for some of it.
std::vector<Delay> delays_during(const History& history, const RunRef& ref, Nanos not_running) {
  const RunTimes& run = history.run(ref);
  const Span whole{run.begin, run.end};
  std::vector<Delay> delays;
  const auto claim = [&](TimePoint begin, Nanos length, PartKind kind, std::optional<NodeId> by) {
    length = std::min(length, not_running);
    if (length <= Nanos{0}) return;
    delays.push_back({{begin, begin + length}, kind, by});
    not_running -= length;
  };
  const std::optional<SubchainId> subchain = history.app().graph.node(ref.node).subchain;
  if (not_running > Nanos{0} && subchain && history.took_turns(*subchain, run.begin)) {
    for (const Delay& delay : delays_in(history, ref, whole)) {
      if (delay.kind == PartKind::kWaitingForSlot || delay.kind == PartKind::kStolen) {
        claim(delay.time.begin, delay.time.end - delay.time.begin, delay.kind, delay.by);
      }
    }
  }
  if (not_running > Nanos{0}) {
    // Runs that began meanwhile pre-empted it. Runs that had begun before may have, too, if it was demoted or the core
    // is shared evenly.
    std::vector<std::pair<RunRef, bool>> others;
    history.each_overlapping(run.core, whole, ref.node,
                             [&](const RunRef& other, bool sure) { others.emplace_back(other, sure); });
    const bool one = std::all_of(others.begin(), others.end(),
                                 [&](const auto& other) { return other.first.node == others.front().first.node; });
    for (const bool began_meanwhile : {true, false}) {
      for (const auto& [other, sure] : others) {
        const RunTimes& times = history.run(other);
        if ((times.begin >= run.begin) != began_meanwhile) continue;
        const bool known = sure || one;
        claim(std::max(times.begin, run.begin), used_in(times, whole),
              known ? PartKind::kPreEmpted : PartKind::kUnexplained, known ? std::optional(other.node) : std::nullopt);
      }
    }
  }
  std::stable_sort(delays.begin(), delays.end(),
                   [](const Delay& a, const Delay& b) { return a.time.begin < b.time.begin; });
  return delays;
}

}  // namespace

std::vector<Part> parts_of_run(const History& history, const RunRef& ref) {
  const RunTimes& run = history.run(ref);
  const Nanos wall = run.end - run.begin;
  const Nanos wait = std::min(run.wait, wall);
  const Nanos running = std::min(run.cpu, wall - wait);
  const Nanos usual = history.usual_cpu(ref.node);
  std::vector<Part> parts;
  TimePoint now = run.begin;
  Nanos ran{0};
  bool waited = wait == Nanos{0};
  const auto put = [&](PartKind kind, Nanos length, std::optional<NodeId> by = {}) {
    if (length <= Nanos{0}) return;
    parts.push_back({kind, now, now + length, ref.node, by});
    now += length;
  };
  // Computing or waiting until then, but no longer than there is of both.
  const auto go_on = [&](TimePoint until) {
    while (now < until) {
      if (!waited && ran >= running / 2) {
        put(PartKind::kDevice, wait);
        waited = true;
        continue;
      }
      const Nanos before_wait = waited ? running - ran : running / 2 - ran;
      const Nanos before_longer = ran < usual ? usual - ran : running;
      const Nanos step = std::min({before_wait, before_longer, until - now, running - ran});
      if (step <= Nanos{0}) return;
      put(ran < usual ? PartKind::kRunning : PartKind::kRunningLonger, step);
      ran += step;
    }
  };
  Nanos delayed{0};
  for (const Delay& delay : delays_during(history, ref, wall - wait - running)) {
    const Nanos length = delay.time.end - delay.time.begin;
    go_on(delay.time.begin);
    put(delay.kind, length, delay.by);
    delayed += length;
  }
  go_on(run.end);
  put(PartKind::kKernel, wall - wait - running - delayed);
  return parts;
}

std::vector<Delay> delays_in(const History& history, const RunRef& ref, Span span) {
  std::vector<Delay> delays;
  if (span.begin >= span.end) return delays;
  const auto put = [&](Span time, PartKind kind, std::optional<NodeId> by) {
    if (time.begin < time.end) delays.push_back({time, kind, by});
  };
  const std::optional<SubchainId> subchain = history.app().graph.node(ref.node).subchain;
  const bool turns = subchain && history.took_turns(*subchain, span.begin);
  const std::vector<Span> active = turns ? history.active(*subchain, span) : std::vector<Span>{};
  const std::vector<History::Theft> thefts = turns ? history.thefts(*subchain, span) : std::vector<History::Theft>{};
  for (const Holder& holder : history.holders(history.run(ref).core, span, ref.node)) {
    const PartKind in_its_slot = holder.unsure ? PartKind::kUnexplained
                                 : holder.node ? PartKind::kPreEmpted
                                               : PartKind::kKernel;
    if (!turns) {
      put(holder.time, in_its_slot, holder.node);
      continue;
    }
    for (TimePoint now = holder.time.begin; now < holder.time.end;) {
      TimePoint until = holder.time.end;
      PartKind kind = PartKind::kWaitingForSlot;
      std::optional<NodeId> by = holder.node;
      for (const Span& own : active) {
        if (own.begin <= now && now < own.end) {
          kind = in_its_slot;
          until = std::min(until, own.end);
        } else if (own.begin > now) {
          until = std::min(until, own.begin);
        }
      }
      for (const History::Theft& theft : thefts) {
        if (theft.time.begin <= now && now < theft.time.end && kind == PartKind::kWaitingForSlot) {
          kind = PartKind::kStolen;
          by = history.app().graph.subchain(theft.thief).head();
          until = std::min(until, theft.time.end);
        } else if (theft.time.begin > now) {
          until = std::min(until, theft.time.begin);
        }
      }
      put({now, until}, kind, by);
      now = until;
    }
  }
  return delays;
}

}  // namespace ctn::why
