#include "record/app_tables.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "graph/build.h"
#include "graph/spec.h"
#include "record/cells.h"
#include "record/open_record.h"

namespace ctn::record {
namespace {

constexpr std::size_t kMaxRows = 10'000;  // of each of an app's tables: far above what apps have

std::optional<std::int64_t> ns(const std::optional<Nanos>& duration) {
  return duration ? std::optional(duration->count()) : std::nullopt;
}
std::optional<double> hz(const std::optional<Rate>& rate) { return rate ? std::optional(rate->hertz()) : std::nullopt; }

Status write_nodes(sqlite::Database& database, const graph::Graph& graph) {
  auto node_row = database.prepare("INSERT INTO nodes VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!node_row) return node_row.error();
  auto mode_row = database.prepare("INSERT INTO modes VALUES (?, ?, ?)");
  if (!mode_row) return mode_row.error();
  for (std::size_t id = 0; id < graph.nodes().size(); ++id) {
    const graph::Node& node = graph.nodes()[id];
    const std::string_view input = node.input == graph::InputKind::kQueue ? "queue" : "latest";
    // A follower has no period of its own, and would run by it if it were read back.
    std::optional<Nanos> period = node.period;
    if (node.follows) period.reset();
    if (auto done = node_row->run(id, std::string_view(node.name), input, node.external, node.unscheduled, ns(period),
                                  ns(node.output_period), hz(node.min_rate), hz(node.max_rate), hz(node.fallback_rate),
                                  node.max_threads, node.needs_input);
        !done) {
      return done;
    }
    for (std::size_t mode = 0; mode < node.modes.size(); ++mode) {
      if (auto done = mode_row->run(id, mode, std::string_view(node.modes[mode])); !done) return done;
    }
  }
  return Done{};
}

Status write_core_kinds(sqlite::Database& database, const graph::App& app) {
  auto row = database.prepare("INSERT INTO core_kinds VALUES (?, ?, ?, ?)");
  if (!row) return row.error();
  for (std::size_t id = 0; id < app.core_kinds.size(); ++id) {
    const graph::CoreKind& kind = app.core_kinds[id];
    if (auto done = row->run(id, std::string_view(kind.name), kind.count, kind.speed); !done) return done;
  }
  return Done{};
}

Status write_edges(sqlite::Database& database, const graph::Graph& graph) {
  auto row = database.prepare("INSERT INTO edges VALUES (?, ?, ?)");
  if (!row) return row.error();
  auto limit_row = database.prepare("INSERT INTO age_limits VALUES (?, ?, ?)");
  if (!limit_row) return limit_row.error();
  for (std::size_t id = 0; id < graph.edges().size(); ++id) {
    const graph::Edge& edge = graph.edges()[id];
    if (auto done = row->run(id, edge.from.index(), edge.to.index()); !done) return done;
    if (!edge.age_limit) continue;
    const std::string_view on_stale = edge.age_limit->on_stale == graph::OnStale::kSkip ? "skip" : "run";
    if (auto done = limit_row->run(id, edge.age_limit->max_age.count(), on_stale); !done) return done;
  }
  return Done{};
}

Status write_path(sqlite::Statement& row, std::size_t id, const std::vector<NodeId>& path) {
  for (std::size_t position = 0; position < path.size(); ++position) {
    if (auto done = row.run(id, position, path[position].index()); !done) return done;
  }
  return Done{};
}

Status write_subchains(sqlite::Database& database, const graph::App& app) {
  auto row = database.prepare("INSERT INTO subchains VALUES (?, ?, ?, ?, ?, ?)");
  if (!row) return row.error();
  auto node_row = database.prepare("INSERT INTO subchain_nodes VALUES (?, ?, ?)");
  if (!node_row) return node_row.error();
  const auto position = [](const std::vector<SubchainId>& list, SubchainId id) {
    return std::find(list.begin(), list.end(), id) - list.begin();
  };
  for (std::size_t id = 0; id < app.graph.subchains().size(); ++id) {
    const graph::Subchain& subchain = app.graph.subchains()[id];
    const auto& off = app.steal.off;
    const bool steals = std::find(off.begin(), off.end(), SubchainId{id}) == off.end();
    if (auto done = row->run(id, std::string_view(subchain.name), subchain.implicit,
                             position(app.order, SubchainId{id}), position(app.steal.priority, SubchainId{id}), steals);
        !done) {
      return done;
    }
    if (auto done = write_path(*node_row, id, subchain.nodes); !done) return done;
  }
  return Done{};
}

Status write_exclusive(sqlite::Database& database, const graph::App& app) {
  auto row = database.prepare("INSERT INTO exclusive VALUES (?, ?, ?, ?)");
  if (!row) return row.error();
  for (std::size_t id = 0; id < app.exclusive.size(); ++id) {
    const graph::ExclusiveGroup& group = app.exclusive[id];
    for (std::size_t position = 0; position < group.nodes.size(); ++position) {
      const auto done = row->run(id, position, std::string_view(group.name), group.nodes[position].index());
      if (!done) return done;
    }
  }
  return Done{};
}

Status write_chains(sqlite::Database& database, const graph::App& app) {
  auto row = database.prepare("INSERT INTO chains VALUES (?, ?, ?, ?)");
  if (!row) return row.error();
  auto node_row = database.prepare("INSERT INTO chain_nodes VALUES (?, ?, ?)");
  if (!node_row) return node_row.error();
  for (std::size_t id = 0; id < app.objective.size(); ++id) {
    const graph::Term& term = app.objective[id];
    const std::string_view metric = term.metric == graph::Metric::kPeriod ? "period" : "response_time";
    if (auto done = row->run(id, metric, term.weight, ns(term.max)); !done) return done;
    if (auto done = write_path(*node_row, id, term.path); !done) return done;
  }
  return Done{};
}

Status write_options(sqlite::Database& database, const graph::App& app) {
  auto meta = MetaWriter::prepare(database);
  if (!meta) return meta.error();
  const graph::SchedulerOptions& options = app.scheduler;
  const std::string_view frames = options.frames == graph::FrameMode::kFixed ? "fixed" : "elastic";
  meta->set("app", std::string_view(app.name))
      .set("option_slack", options.slack)
      .set("option_frames", frames)
      .set("option_min_slice_ns", options.min_slice.count())
      .set("option_window", options.window)
      .set("option_percentile", options.percentile)
      .set("option_bootstrap_ns", options.bootstrap.count())
      .set("option_bootstrap_cost_ns", options.bootstrap_cost.count())
      .set("option_replan_ns", options.replan.count());
  return meta->status();
}

// Reads an app's tables one after the other into a specification; the first failure ends it.
class AppReader {
 public:
  explicit AppReader(sqlite::Database& database) : database_(database) {}

  Result<graph::App> read(const Meta& meta) {
    spec_.name.value = meta.text("app").value_or("");
    spec_.order.emplace();
    spec_.steal_priority.emplace();
    for (const auto step :
         {&AppReader::read_core_kinds, &AppReader::read_nodes, &AppReader::read_modes, &AppReader::read_edges,
          &AppReader::read_age_limits, &AppReader::read_subchains, &AppReader::read_subchain_nodes,
          &AppReader::read_exclusive, &AppReader::read_chains, &AppReader::read_chain_nodes}) {
      if (auto done = (this->*step)(); !done) return done.error();
    }
    if (!read_options(meta)) return damaged(database_, "meta");
    order_subchains();
    return graph::build_app(spec_);
  }

 private:
  // Calls `take` for each row; it refuses what no writer wrote through the cells.
  Status each_row(const std::string& table, const std::string& columns, const std::string& order,
                  const std::function<void(Cells&)>& take) {
    std::size_t count = 0;
    const auto take_row = [&](sqlite::Statement& row) -> Status {
      if (count++ >= kMaxRows) return damaged(database_, table);
      Cells cells(row);
      take(cells);
      if (!cells.ok()) return damaged(database_, table);
      return Done{};
    };
    return database_.each_row("SELECT " + columns + " FROM " + table + " ORDER BY " + order, take_row);
  }

  Status read_core_kinds() {
    return each_row("core_kinds", "id, name, count, speed", "id", [this](Cells& cells) {
      expect_next(cells, 0, spec_.core_kinds.size());
      graph::CoreKindSpec kind;
      kind.name.value = cells.text(1);
      kind.count.value = static_cast<int>(cells.integer(2, 1, std::numeric_limits<int>::max()));
      kind.speed.value = cells.real(3);
      spec_.core_kinds.push_back(std::move(kind));
    });
  }

  Status read_nodes() {
    const auto has_needs =
        one_integer(database_, "SELECT count(*) FROM pragma_table_info('nodes') WHERE name = 'needs_input'");
    if (!has_needs) return has_needs.error();
    const std::string columns =
        std::string(
            "id, name, input, external, unscheduled, period_ns, output_period_ns, min_rate_hz, max_rate_hz, "
            "fallback_rate_hz, max_threads, ") +
        (*has_needs == 1 ? "needs_input" : "0");
    return each_row("nodes", columns, "id", [this](Cells& cells) {
      graph::NodeSpec node;
      expect_next(cells, 0, spec_.nodes.size());
      node.name.value = cells.text(1);
      const std::string input = cells.text(2);
      if (input != "queue" && input != "latest") cells.refuse();
      if (input == "queue") node.input = graph::InputKind::kQueue;
      node.external = cells.flag(3);
      node.unscheduled = cells.flag(4);
      node.period = duration(cells, 5);
      node.output_period = duration(cells, 6);
      node.min_rate = rate(cells, 7);
      node.max_rate = rate(cells, 8);
      node.fallback_rate = rate(cells, 9);
      // 1 is what a node has that says nothing; to say it of an external node would be an error.
      const auto threads = static_cast<int>(cells.integer(10, 1, std::numeric_limits<int>::max()));
      if (threads != 1) node.max_threads = graph::At<int>{threads, {}};
      node.needs_input = cells.flag(11);
      spec_.nodes.push_back(std::move(node));
    });
  }

  Status read_modes() {
    return each_row("modes", "node, mode, name", "node, mode", [this](Cells& cells) {
      const std::size_t node = cells.index(0, spec_.nodes.size());
      if (!cells.ok()) return;
      expect_next(cells, 1, spec_.nodes[node].modes.size());
      spec_.nodes[node].modes.push_back({cells.text(2), {}});
    });
  }

  Status read_edges() {
    return each_row("edges", "id, from_node, to_node", "id", [this](Cells& cells) {
      expect_next(cells, 0, spec_.edges.size());
      graph::PathSpec edge;
      edge.nodes = {node_name(cells, 1), node_name(cells, 2)};
      spec_.edges.push_back(std::move(edge));
    });
  }

  Status read_age_limits() {
    return each_row("age_limits", "edge, max_age_ns, on_stale", "edge", [this](Cells& cells) {
      const std::size_t edge = cells.index(0, spec_.edges.size());
      if (!cells.ok()) return;
      spec_.edges[edge].max_age = graph::At<Nanos>{cells.duration(1), {}};
      const std::string on_stale = cells.text(2);
      if (on_stale != "run" && on_stale != "skip") cells.refuse();
      const bool skips = on_stale == "skip";
      spec_.edges[edge].on_stale = graph::At<graph::OnStale>{skips ? graph::OnStale::kSkip : graph::OnStale::kRun, {}};
    });
  }

  Status read_subchains() {
    const std::string columns = "id, name, implicit, slot_order, steal_rank, steals";
    return each_row("subchains", columns, "id", [this](Cells& cells) {
      expect_next(cells, 0, subchains_.size());
      subchains_.push_back({.spec = {{cells.text(1), {}}, {}},
                            .implicit = cells.flag(2),
                            .slot_order = cells.integer(3),
                            .steal_rank = cells.integer(4)});
      if (!cells.flag(5)) spec_.steal_off.push_back(subchains_.back().spec.name);
    });
  }

  Status read_subchain_nodes() {
    return each_row("subchain_nodes", "subchain, position, node", "subchain, position", [this](Cells& cells) {
      const std::size_t subchain = cells.index(0, subchains_.size());
      if (!cells.ok()) return;
      expect_next(cells, 1, subchains_[subchain].spec.nodes.size());
      subchains_[subchain].spec.nodes.push_back(node_name(cells, 2));
    });
  }

  Status read_exclusive() {
    return each_row("exclusive", "id, position, name, node", "id, position", [this](Cells& cells) {
      if (cells.integer(1) == 0) {
        expect_next(cells, 0, spec_.exclusive.size());
        spec_.exclusive.push_back({{cells.text(2), {}}, {}});
      }
      if (!cells.ok() || spec_.exclusive.empty()) return cells.refuse();
      expect_next(cells, 1, spec_.exclusive.back().nodes.size());
      spec_.exclusive.back().nodes.push_back(node_name(cells, 3));
    });
  }

  Status read_chains() {
    return each_row("chains", "id, metric, weight, max_ns", "id", [this](Cells& cells) {
      graph::TermSpec term;
      expect_next(cells, 0, spec_.objective.size());
      const std::string metric = cells.text(1);
      if (metric != "period" && metric != "response_time") cells.refuse();
      if (metric == "period") term.metric = graph::Metric::kPeriod;
      term.weight.value = cells.real(2);
      term.max = duration(cells, 3);
      spec_.objective.push_back(std::move(term));
    });
  }

  Status read_chain_nodes() {
    return each_row("chain_nodes", "chain, position, node", "chain, position", [this](Cells& cells) {
      const std::size_t chain = cells.index(0, spec_.objective.size());
      if (!cells.ok()) return;
      expect_next(cells, 1, spec_.objective[chain].path.size());
      spec_.objective[chain].path.push_back(node_name(cells, 2));
    });
  }

  bool read_options(const Meta& meta) {
    graph::SchedulerOptions& options = spec_.scheduler;
    const auto frames = meta.text("option_frames");
    const auto min_slice = meta.duration("option_min_slice_ns");
    const auto window = meta.integer("option_window");
    const auto percentile = meta.real("option_percentile");
    const auto bootstrap = meta.duration("option_bootstrap_ns");
    const auto bootstrap_cost = meta.duration("option_bootstrap_cost_ns");
    const auto replan = meta.duration("option_replan_ns");
    if (!frames || !min_slice || !window || !percentile || !bootstrap || !bootstrap_cost || !replan) return false;
    if (*window < 1 || *window > std::numeric_limits<int>::max() || *percentile <= 0.0 || *percentile > 100.0) {
      return false;
    }
    options.slack = meta.real("option_slack");
    if (options.slack && (*options.slack < 0.0 || *options.slack >= 1.0)) return false;
    if (*frames != "fixed" && *frames != "elastic") return false;
    options.frames = *frames == "fixed" ? graph::FrameMode::kFixed : graph::FrameMode::kElastic;
    options.min_slice = *min_slice;
    options.window = static_cast<int>(*window);
    options.percentile = *percentile;
    options.bootstrap = *bootstrap;
    options.bootstrap_cost = *bootstrap_cost;
    options.replan = *replan;
    return true;
  }

  // Subchains that the app file does not name arise again by themselves; the lists name all.
  void order_subchains() {
    for (const Entry& entry : subchains_) {
      if (!entry.implicit) spec_.subchains.push_back(entry.spec);
    }
    const auto names_by = [this](std::int64_t Entry::*key) {
      std::vector<Entry> sorted = subchains_;
      std::stable_sort(sorted.begin(), sorted.end(), [&](const Entry& a, const Entry& b) { return a.*key < b.*key; });
      std::vector<graph::Name> names;
      for (const Entry& entry : sorted) names.push_back(entry.spec.name);
      return names;
    };
    spec_.order = names_by(&Entry::slot_order);
    spec_.steal_priority = names_by(&Entry::steal_rank);
  }

  static void expect_next(Cells& cells, int column, std::size_t next) {
    if (cells.integer(column) != static_cast<std::int64_t>(next)) cells.refuse();
  }
  static std::optional<graph::At<Nanos>> duration(Cells& cells, int column) {
    if (cells.null(column)) return std::nullopt;
    return graph::At<Nanos>{cells.duration(column), {}};
  }
  static std::optional<graph::At<Rate>> rate(Cells& cells, int column) {
    if (cells.null(column)) return std::nullopt;
    const double hertz = cells.real(column);
    if (hertz > 0.0) return graph::At<Rate>{Rate{hertz}, {}};
    cells.refuse();
    return std::nullopt;
  }
  graph::Name node_name(Cells& cells, int column) {
    const std::size_t node = cells.index(column, spec_.nodes.size());
    return cells.ok() ? spec_.nodes[node].name : graph::Name{};
  }

  struct Entry {
    graph::SubchainSpec spec;
    bool implicit = false;
    std::int64_t slot_order = 0;
    std::int64_t steal_rank = 0;
  };
  sqlite::Database& database_;
  graph::AppSpec spec_;
  std::vector<Entry> subchains_;
};

}  // namespace

Status write_app(sqlite::Database& database, const graph::App& app) {
  for (const auto step : {write_nodes, write_edges}) {
    if (auto done = step(database, app.graph); !done) return done;
  }
  for (const auto step : {write_core_kinds, write_subchains, write_exclusive, write_chains, write_options}) {
    if (auto done = step(database, app); !done) return done;
  }
  return Done{};
}

Result<graph::App> read_app(sqlite::Database& database, const Meta& meta) { return AppReader(database).read(meta); }

}  // namespace ctn::record
