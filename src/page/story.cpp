#include "page/story.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plan/json.h"
#include "record/app_changes.h"
#include "record/lineage.h"
#include "why/why.h"

namespace ctn::page {
namespace {

// A damaged record may name any number of cores; a page has rows for at most this many.
constexpr std::size_t kMaxCores = 1024;

Micros micros(Nanos duration) { return std::chrono::floor<std::chrono::microseconds>(duration).count(); }

class Teller {
 public:
  Teller(const record::Reader& record, Story& story) : record_(record), story_(story) {
    started_ = record.header().started;
    story.app = record.app();
    story.duration = std::max<Micros>(micros(record.ending().ended - started_), 1);
    add_lanes();
  }

  Status tell(bool whole) {
    const auto clocks = record_.clocks();
    if (!clocks) return clocks.error();
    for (const graph::Term& term : story_.app.objective) {
      if (term.metric == graph::Metric::kResponseTime) trackers_.emplace_back(story_.app.graph, term.path);
    }
    story_.responses.resize(trackers_.size());
    auto reading = clocks->begin();
    auto history = std::make_shared<why::History>(story_.app, record_.header().cpus.size());
    const auto see = [&](const record::Run& run) {
      for (; reading != clocks->end() && reading->at <= run.end; ++reading) {
        for (record::ChainTracker& tracker : trackers_) tracker.set_clock(reading->node, reading->ticks);
        history->add(*reading);
      }
      history->add(run);
      add(run);
    };
    auto figures = report::measure(record_, {.whole = whole, .worst = kWorstShown, .see = see});
    if (!figures) return figures.error();
    for (auto& responses : story_.responses) {
      std::stable_sort(responses.begin(), responses.end(), [](const auto& a, const auto& b) { return a.end < b.end; });
    }
    story_.figures = std::move(*figures);
    if (auto done = why::add_all_but_runs(record_, *history); !done) return done;
    history->sort();
    story_.history = std::move(history);
    story_.measured_from = whole ? 0 : std::min(micros(record_.header().warm_up), story_.duration);
    if (auto done = add_triggers(); !done) return done;
    if (auto done = add_slots(); !done) return done;
    if (auto done = add_plans(); !done) return done;
    return add_events();
  }

 private:
  Micros when(TimePoint time) const { return std::clamp<Micros>(micros(time - started_), 0, story_.duration); }

  void add_lanes() {
    const graph::Graph& graph = story_.app.graph;
    story_.lane_of.assign(graph.nodes().size(), kNoLane);
    for (const graph::Subchain& subchain : graph.subchains()) {
      for (const NodeId node : subchain.nodes) story_.lane_of[node.index()] = story_.lanes.size();
      story_.lanes.push_back({subchain.name, subchain.nodes});
    }
    for (std::size_t i = 0; i < graph.nodes().size(); ++i) {
      if (!graph.nodes()[i].unscheduled) continue;
      story_.lane_of[i] = story_.lanes.size();
      story_.lanes.push_back({graph.nodes()[i].name, {NodeId(i)}, false});
    }
    story_.triggers.resize(story_.lanes.size());
  }

  void add(const record::Run& run) {
    const auto node = static_cast<std::uint32_t>(run.node.index());
    if (story_.lane_of[node] != kNoLane) {
      story_.runs.push_back({node, run.mode, run.number, when(run.begin), when(run.end),
                             static_cast<float>(to_millis(run.cpu).count()),
                             static_cast<float>(to_millis(run.wait).count())});
    }
    for (std::size_t i = 0; i < trackers_.size(); ++i) {
      for (const record::ChainSample& sample : trackers_[i].add(run)) {
        if (sample.response) story_.responses[i].push_back({when(sample.end), to_millis(*sample.response).count()});
      }
    }
  }

  Status add_triggers() {
    const Status done = record_.each_trigger([&](const record::Trigger& trigger) {
      story_.triggers[trigger.subchain.index()].push_back({when(trigger.sent), micros(trigger.sent - trigger.due)});
    });
    for (auto& triggers : story_.triggers) {
      std::sort(triggers.begin(), triggers.end(), [](const auto& a, const auto& b) { return a.sent < b.sent; });
    }
    return done;
  }

  void see_core(std::size_t core) { story_.cores = std::max(story_.cores, core + 1); }

  Status add_slots() {
    const auto span = [&](int core, SubchainId lane, TimePoint begin, TimePoint end) {
      return SlotSpan{static_cast<std::size_t>(core), lane.index(), when(begin), std::max(when(begin), when(end))};
    };
    if (auto done = record_.each_slot([&](const record::SlotUse& slot) {
          if (static_cast<std::size_t>(slot.core) >= kMaxCores) return;
          see_core(static_cast<std::size_t>(slot.core));
          story_.slots.push_back(span(slot.core, slot.subchain, slot.begin, slot.end));
        });
        !done) {
      return done;
    }
    const Status done = record_.each_steal([&](const record::Steal& steal) {
      if (static_cast<std::size_t>(steal.core) >= kMaxCores) return;
      see_core(static_cast<std::size_t>(steal.core));
      story_.steals.push_back({span(steal.core, steal.thief, steal.begin, steal.end), steal.victim.index()});
    });
    std::sort(story_.slots.begin(), story_.slots.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
    std::sort(story_.steals.begin(), story_.steals.end(),
              [](const auto& a, const auto& b) { return a.slot.begin < b.slot.begin; });
    return done;
  }

  Status add_plans() {
    const auto changes = record_.plans();
    if (!changes) return changes.error();
    for (std::size_t i = 0; i < changes->size(); ++i) {
      const record::PlanChange& change = (*changes)[i];
      const auto plan = plan::from_json(change.json, story_.app, fmt::format("plan {} of the record", i + 1));
      if (!plan) return plan.error();
      story_.plans.push_back(span_of(*plan, when(change.at), change.reason));
      event(change.at, EventKind::kPlan, "plan: " + change.reason);
    }
    std::stable_sort(story_.plans.begin(), story_.plans.end(),
                     [](const auto& a, const auto& b) { return a.at < b.at; });
    return Done{};
  }

  PlanSpan span_of(const plan::Plan& plan, Micros at, const std::string& reason) {
    PlanSpan span{at, reason, {}, {}};
    for (std::size_t lane = 0; lane < plan.subchains.size(); ++lane) {
      for (const int core : plan.subchains[lane].cores) {
        if (core < 0 || static_cast<std::size_t>(core) >= std::min(kMaxCores, plan.cores.size())) continue;
        const auto index = static_cast<std::size_t>(core);
        see_core(index);
        const auto& members = plan.cores[index].members;
        const auto member = std::find_if(members.begin(), members.end(),
                                         [&](const plan::Member& one) { return one.subchain.index() == lane; });
        span.placements.push_back({lane, index, member == members.end() ? 0 : member->priority});
      }
    }
    std::stable_sort(span.placements.begin(), span.placements.end(), [](const Placement& a, const Placement& b) {
      return std::pair(a.core, -a.priority) < std::pair(b.core, -b.priority);
    });
    if (plan.chains.size() != story_.responses.size()) return span;
    for (std::size_t i = 0; i < plan.chains.size(); ++i) {
      span.chains.push_back({plan.chains[i].response.count(), std::nullopt});
      if (plan.expected && plan.expected->chains.size() == plan.chains.size()) {
        span.chains.back().expected_ms = plan.expected->chains[i].response.count();
      }
    }
    return span;
  }

  void event(TimePoint at, EventKind kind, std::string text, std::optional<std::size_t> lane = {},
             std::optional<std::size_t> node = {}) {
    story_.events.push_back({when(at), kind, std::move(text), lane, node});
  }

  Status add_events() {
    const graph::Graph& graph = story_.app.graph;
    const auto costs = record_.cost_changes();
    if (!costs) return costs.error();
    for (const record::CostChange& change : *costs) {
      const graph::Node& node = graph.node(change.node);
      const std::string mode = change.mode < node.modes.size() ? " (" + node.modes[change.mode] + ")" : "";
      event(change.at, EventKind::kCost,
            fmt::format("{}{} costs {:.3g} ms, before {:.3g} ms", node.name, mode, to_millis(change.after).count(),
                        to_millis(change.before).count()),
            {}, change.node.index());
    }
    const auto changes = record_.app_changes();
    if (!changes) return changes.error();
    for (const record::AppChange& change : *changes) {
      event(change.at, EventKind::kChange, record::describe(record_.app(), change));
    }
    for (const record::Notice& notice : story_.figures.notices) {
      event(notice.at, EventKind::kNotice, notice.kind + ": " + notice.detail);
    }
    const Status done = record_.each_overrun([&](const record::Overrun& overrun) {
      event(overrun.at, EventKind::kOverrun,
            fmt::format("{} overran its budget: {:.3g} ms used", graph.subchain(overrun.subchain).name,
                        to_millis(overrun.cpu).count()),
            overrun.subchain.index());
    });
    std::stable_sort(story_.events.begin(), story_.events.end(),
                     [](const Event& a, const Event& b) { return a.at < b.at; });
    return done;
  }

  const record::Reader& record_;
  Story& story_;
  TimePoint started_;
  std::vector<record::ChainTracker> trackers_;
};

}  // namespace

const char* to_string(EventKind kind) {
  switch (kind) {
    case EventKind::kPlan:
      return "plan";
    case EventKind::kCost:
      return "cost";
    case EventKind::kChange:
      return "change";
    case EventKind::kNotice:
      return "notice";
    case EventKind::kOverrun:
      return "overrun";
  }
  return "";
}

Result<Story> tell(const record::Reader& record, bool whole) {
  Story story;
  if (auto done = Teller(record, story).tell(whole); !done) return done.error();
  return story;
}

Micros when(const Story& story, TimePoint time) {
  return std::clamp<Micros>(micros(time - story.figures.header.started), 0, story.duration);
}

const PlanSpan* plan_at(const Story& story, Micros at) {
  const auto next = std::upper_bound(story.plans.begin(), story.plans.end(), at,
                                     [](Micros time, const PlanSpan& plan) { return time < plan.at; });
  return next == story.plans.begin() ? nullptr : &*(next - 1);
}

}  // namespace ctn::page
