// For tests of exports: a record with one of everything, and one that is hostile.
#pragma once

#include <string>

#include "export/output.h"
#include "plan/json.h"
#include "record/testing/record_fixture.h"

namespace ctn::exports::test {

using namespace record::test;

const std::string kHostile = "a,\"b\"\r\n<c>\xff\x01";

// A plan with that period for every subchain, which promises three times as much for every chain. The first subchain
// owns a core; the others take turns.
inline std::string plan_json(const graph::App& app, double period) {
  plan::Plan plan;
  plan.planner = "auto";
  plan.objective = 10.0 * period;
  for (std::size_t i = 0; i < app.graph.subchains().size(); ++i) {
    plan::SubchainPlan subchain;
    subchain.cores = {static_cast<int>(i)};
    subchain.period = subchain.execution = Millis{period};
    subchain.slice = Millis{period / 2};
    subchain.share = 0.5;
    subchain.every = 1;
    plan.subchains.push_back(subchain);
    plan.cores.emplace_back();
    if (i > 0) plan.cores.back().slots.push_back({SubchainId{i}, Millis{0}, Millis{period}, 1, 0});
  }
  for (const graph::Term& term : app.objective) {
    if (term.metric == graph::Metric::kPeriod) {
      plan.nodes.push_back({term.path.front(), Millis{period}, term.weight});
    } else {
      plan.chains.push_back({term.path, Millis{3 * period}, Millis{2 * period}, Millis{period}, term.weight});
    }
  }
  return plan::to_json(plan, app);
}

// Two rounds of runs at 103 s (record_fixture.h), and one event of every other kind, between 100 s and 110 s.
inline void add_sample(record::Writer& writer, const graph::App& app) {
  for (const record::Run& run : runs(app, seconds{103}, 1)) writer.add(run);
  for (std::uint64_t i = 1; i < 3; ++i) {
    const TimePoint due = at(seconds{103} + milliseconds{20 * (i - 1)});
    writer.add(record::Trigger{SubchainId{0}, i, due, due + microseconds{250}});
  }
  writer.add(record::SlotUse{1, SubchainId{1}, at(milliseconds{103'029}), at(milliseconds{103'030}),
                             at(milliseconds{103'040})});
  writer.add(record::Steal{1, SubchainId{0}, SubchainId{1}, at(milliseconds{103'028}), at(milliseconds{103'030})});
  writer.add(record::Overrun{SubchainId{0}, 2, at(milliseconds{103'023}), microseconds{2500}});
  writer.add(record::PlanChange{at(seconds{100}), "bootstrap", plan_json(app, 50.0)});
  writer.add(record::PlanChange{at(seconds{102}), "measured", plan_json(app, 10.0)});
  writer.add(
      record::CostChange{at(seconds{104}), *app.graph.find_node("GL"), 1, 1, milliseconds{4}, milliseconds{8}, 6});
  writer.add(record::AppChange{at(seconds{105}), record::AppChange::What::kMax, 0, 60.0, 40.5});
  writer.add(record::Notice{at(seconds{106}), "watchdog", kHostile});
}

// What Catan never writes: runs of a node that overlap, slots that cross or end before they begin, a mode that
// is not there, inputs over edges that are not there, inputs of endless ranges of runs, plans out of order.
inline void add_nonsense(record::Writer& writer, const graph::App& app) {
  const auto id = [&](const char* name) { return *app.graph.find_node(name); };
  for (std::uint64_t i = 1; i < 30; ++i) {
    const TimePoint begin = at(seconds{101} + milliseconds{(7 * i) % 10});
    writer.add(record::Run{id("GL"),
                           i,
                           begin,
                           begin + milliseconds{i % 5},
                           Nanos{1},
                           77,
                           true,
                           {{id("base"), 1, 5}, {id("scan"), 1, std::uint64_t{1} << 60}}});
    writer.add(record::Run{id("scan"), i, begin, begin + milliseconds{3}, Nanos{1}, 0, true, {}});
    writer.add(record::Trigger{SubchainId{0}, i, begin + milliseconds{i % 3}, begin});
    writer.add(record::SlotUse{1000, SubchainId{1}, begin, begin + milliseconds{i % 3}, begin});
    writer.add(record::SlotUse{1000, SubchainId{0}, begin, begin, begin + milliseconds{i % 4}});
    writer.add(record::Steal{7, SubchainId{1}, SubchainId{1}, begin, at(seconds{100})});
  }
  writer.add(record::Run{id("base"), 1, at(seconds{1}), at(seconds{200}), Nanos{1}, 0, true, {}});
  writer.add(record::PlanChange{at(seconds{109}), kHostile, plan_json(app, 10.0)});
  writer.add(record::PlanChange{at(seconds{101}), kHostile, plan_json(app, 20.0)});
  writer.add(record::Notice{at(seconds{1}), kHostile, kHostile});
}

inline Sink into(std::string& text) {
  return [&text](std::string_view bytes) -> Status {
    text += bytes;
    return Done{};
  };
}

}  // namespace ctn::exports::test
