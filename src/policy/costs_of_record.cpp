#include "policy/costs_of_record.h"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "policy/cpu_kinds.h"

namespace ctn::policy {

Result<MeasuredCosts> costs_of_record(const record::Reader& record, const graph::App& app) {
  const os::CpuSet cpus(record.header().cpus);
  if (Status fits = CpuKinds::fits(app, cpus); !fits) return fits.error();
  const CpuKinds kinds(app, cpus);
  std::vector<std::optional<NodeId>> ours;  // by the record's nodes
  for (const graph::Node& node : record.app().graph.nodes()) ours.push_back(app.graph.find_node(node.name));

  Result<std::vector<record::ClockReading>> clocks = record.clocks();
  if (!clocks) return clocks.error();
  auto reading = clocks->begin();

  MeasuredCosts measured(app, RunsThatCount::kAll);
  const Status read = record.each_run([&](const record::Run& recorded) {
    for (; reading != clocks->end() && reading->at <= recorded.end; ++reading) {
      const std::optional<NodeId> ticks = ours[reading->node.index()];
      if (ticks) measured.set_clock(*ticks, reading->ticks);
    }
    const std::optional<NodeId> node = ours[recorded.node.index()];
    if (!node) return;
    record::Run run = recorded;
    run.node = *node;
    run.consumed.clear();
    for (const record::Consumed& consumed : recorded.consumed) {
      const std::optional<NodeId> from = ours[consumed.predecessor.index()];
      if (from) run.consumed.push_back({*from, consumed.first, consumed.last});
    }
    measured.add(run, kinds.of(run.on_cpu));
  });
  if (!read) return read.error();

  std::vector<Problem> problems;
  for (const NodeId node : measured.unknown()) {
    problems.push_back({{},
                        {},
                        fmt::format("the record has no run of node {}", app.graph.node(node).name),
                        "record a run of this app in which every node runs"});
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return measured;
}

}  // namespace ctn::policy
