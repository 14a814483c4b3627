#include "export/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "export/csv_writer.h"
#include "export/in_force.h"
#include "export/responses.h"
#include "plan/json.h"
#include "record/app_changes.h"

namespace ctn::exports {
namespace {

// What every table is made from.
struct Source {
  const record::Reader& record;
  const Sink& sink;
  const Progress& progress;

  const graph::Graph& graph() const { return record.app().graph; }
  const std::string& name(NodeId node) const { return graph().node(node).name; }
  const std::string& name(SubchainId subchain) const { return graph().subchain(subchain).name; }
  std::string mode(NodeId node, std::uint32_t mode) const {
    const std::vector<std::string>& modes = graph().node(node).modes;
    if (mode < modes.size()) return modes[mode];
    return modes.empty() ? std::string() : fmt::format("{}", mode);
  }
  CsvWriter writer(std::string_view columns) const { return {sink, record.header().started, columns}; }

  // Of all that was recorded, up to this moment.
  void tell(TimePoint at) const {
    const TimePoint started = record.header().started;
    const Millis whole = record.ending().ended - started;
    if (whole > Millis{0}) progress(std::clamp(Millis{at - started} / whole, 0.0, 1.0));
  }
};

// Keeps the first failure of reading or writing.
Status both(const Status& done, CsvWriter& csv) {
  if (!done) return done;
  return csv.finish();
}

Status write_runs(const Source& source) {
  CsvWriter csv = source.writer("node,run,begin_s,end_s,cpu_ms,wait_ms,mode,emitted,on_cpu");
  const Status done = source.record.each_run_by_begin([&](const record::Run& run) {
    csv.text(source.name(run.node)).number(run.number).seconds(run.begin).seconds(run.end);
    csv.ms(run.cpu).ms(run.wait).text(source.mode(run.node, run.mode)).number(run.emitted ? 1 : 0);
    csv.number(run.on_cpu >= 0 ? std::optional<std::uint64_t>(run.on_cpu) : std::nullopt).end_line();
    source.tell(run.end);
  });
  return both(done, csv);
}

Status write_consumed(const Source& source) {
  CsvWriter csv = source.writer("node,run,predecessor,first_run,last_run");
  const Status done = source.record.each_run([&](const record::Run& run) {
    for (const record::Consumed& input : run.consumed) {
      csv.text(source.name(run.node)).number(run.number).text(source.name(input.predecessor));
      csv.number(input.first).number(input.last).end_line();
    }
    source.tell(run.end);
  });
  return both(done, csv);
}

Status write_triggers(const Source& source) {
  CsvWriter csv = source.writer("subchain,trigger,due_s,sent_s,late_ms");
  const Status done = source.record.each_trigger([&](const record::Trigger& trigger) {
    csv.text(source.name(trigger.subchain)).number(trigger.number).seconds(trigger.due).seconds(trigger.sent);
    csv.ms(trigger.sent - trigger.due).end_line();
  });
  return both(done, csv);
}

Status write_slots(const Source& source) {
  CsvWriter csv = source.writer("core,subchain,planned_s,begin_s,end_s");
  const Status done = source.record.each_slot([&](const record::SlotUse& slot) {
    csv.number(static_cast<std::uint64_t>(slot.core)).text(source.name(slot.subchain));
    csv.seconds(slot.planned).seconds(slot.begin).seconds(slot.end).end_line();
  });
  return both(done, csv);
}

Status write_steals(const Source& source) {
  CsvWriter csv = source.writer("core,thief,victim,begin_s,end_s");
  const Status done = source.record.each_steal([&](const record::Steal& steal) {
    csv.number(static_cast<std::uint64_t>(steal.core)).text(source.name(steal.thief)).text(source.name(steal.victim));
    csv.seconds(steal.begin).seconds(steal.end).end_line();
  });
  return both(done, csv);
}

Status write_overruns(const Source& source) {
  CsvWriter csv = source.writer("subchain,trigger,at_s,cpu_ms");
  const Status done = source.record.each_overrun([&](const record::Overrun& overrun) {
    csv.text(source.name(overrun.subchain)).number(overrun.number).seconds(overrun.at).ms(overrun.cpu).end_line();
  });
  return both(done, csv);
}

Status write_plans(const Source& source) {
  CsvWriter csv = source.writer("plan,at_s,reason,planner,objective_ms,relax_factor,promises_for");
  const auto changes = source.record.plans();
  if (!changes) return changes.error();
  for (std::size_t i = 0; i < changes->size(); ++i) {
    const record::PlanChange& change = (*changes)[i];
    const auto plan = plan::from_json(change.json, source.record.app(), fmt::format("plan {} of the record", i + 1));
    if (!plan) return plan.error();
    csv.number(i + 1).seconds(change.at).text(change.reason).text(plan->planner).real(plan->objective);
    csv.real(plan->relax_factor).text(plan::promises_for(plan->for_typical)).end_line();
  }
  return csv.finish();
}

Status write_cost_changes(const Source& source) {
  CsvWriter csv = source.writer("at_s,node,mode,core_kind,before_ms,after_ms,runs");
  const auto changes = source.record.cost_changes();
  if (!changes) return changes.error();
  const std::vector<graph::CoreKind>& kinds = source.record.app().core_kinds;
  for (const record::CostChange& change : *changes) {
    const auto kind = static_cast<std::size_t>(change.core_kind);
    csv.seconds(change.at).text(source.name(change.node)).text(source.mode(change.node, change.mode));
    csv.text(kind < kinds.size() ? kinds[kind].name : "").ms(change.before).ms(change.after).number(change.runs);
    csv.end_line();
  }
  return csv.finish();
}

Status write_app_changes(const Source& source) {
  CsvWriter csv = source.writer("at_s,change");
  const auto changes = source.record.app_changes();
  if (!changes) return changes.error();
  for (const record::AppChange& change : *changes) {
    csv.seconds(change.at).text(record::describe(source.record.app(), change)).end_line();
  }
  return csv.finish();
}

Status write_notices(const Source& source) {
  CsvWriter csv = source.writer("at_s,kind,detail");
  const auto notices = source.record.notices();
  if (!notices) return notices.error();
  for (const record::Notice& notice : *notices) {
    csv.seconds(notice.at).text(notice.kind).text(notice.detail).end_line();
  }
  return csv.finish();
}

Status write_responses(const Source& source) {
  CsvWriter csv =
      source.writer("chain,source_run,begin_s,end_s,latency_ms,period_ms,response_ms,promised_ms,expected_ms,bound_ms");
  auto in_force = InForce::at_start(source.record);
  if (!in_force) return in_force.error();
  std::vector<std::string> chains;
  for (const graph::Term& term : source.record.app().objective) {
    if (term.metric == graph::Metric::kResponseTime) chains.push_back(source.graph().path_name(term.path));
  }
  Status status = Done{};
  const Status done = each_response(
      source.record,
      [&](const record::Run& run) {
        if (status) status = in_force->move_to(run.end);
        source.tell(run.end);
      },
      [&](std::size_t chain, const record::ChainSample& sample) {
        const auto millis = [](std::optional<Nanos> time) {
          return time ? std::optional(to_millis(*time).count()) : std::nullopt;
        };
        const auto predicted = in_force->predicted(chain);
        csv.text(chains[chain]).number(sample.source_run).seconds(sample.begin).seconds(sample.end).ms(sample.latency);
        csv.real(millis(sample.period)).real(millis(sample.response));
        csv.real(predicted ? std::optional(predicted->promised_response_ms) : std::nullopt);
        csv.real(predicted ? std::optional(predicted->response_ms) : std::nullopt);
        csv.real(in_force->bound_ms(chain)).end_line();
      });
  return both(done ? status : done, csv);
}

struct Table {
  std::string_view name;
  Status (*write)(const Source&);
};

constexpr std::array<Table, 11> kTables{{{"runs", write_runs},
                                         {"consumed", write_consumed},
                                         {"triggers", write_triggers},
                                         {"slots", write_slots},
                                         {"steals", write_steals},
                                         {"overruns", write_overruns},
                                         {"plans", write_plans},
                                         {"cost_changes", write_cost_changes},
                                         {"app_changes", write_app_changes},
                                         {"notices", write_notices},
                                         {"responses", write_responses}}};

constexpr std::array<std::string_view, kTables.size()> names_of_tables() {
  std::array<std::string_view, kTables.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kTables[i].name;
  return names;
}
constexpr auto kNames = names_of_tables();

}  // namespace

std::span<const std::string_view> csv_tables() { return kNames; }

Status write_csv(const record::Reader& record, std::string_view table, const Sink& sink, const Progress& progress) {
  const auto* const found =
      std::find_if(kTables.begin(), kTables.end(), [&](const Table& one) { return one.name == table; });
  return found->write({record, sink, progress});
}

}  // namespace ctn::exports
