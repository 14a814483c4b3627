#include "record/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <queue>
#include <string_view>
#include <tuple>

#include "record/app_changes.h"
#include "record/app_tables.h"
#include "record/cells.h"
#include "record/meta.h"
#include "record/open_record.h"
#include "record/sqlite.h"

namespace ctn::record {
namespace {

constexpr int kMaxCores = 1 << 20;

Result<Header> read_header(const sqlite::Database& database, const Meta& meta) {
  const auto cpus = os::parse_cpu_list(meta.text("cpus").value_or(""));
  const auto started = meta.duration("started_ns");
  const auto warm_up = meta.duration("warm_up_ns");
  const auto steal = meta.duration("host_steal_ns");
  const auto cpu_count = meta.integer("host_cpu_count");
  const auto real_time = meta.integer("real_time");
  if (!cpus || !started || !warm_up || !steal || !cpu_count || !real_time || *cpu_count < 0 ||
      *cpu_count > std::numeric_limits<int>::max()) {
    return damaged(database, "meta");
  }
  Header header;
  header.scheduler = meta.text("scheduler").value_or("");
  header.cpus = *cpus;
  header.host = {.utc = meta.text("started_utc").value_or(""),
                 .kernel = meta.text("host_kernel").value_or(""),
                 .cpu_model = meta.text("host_cpu_model").value_or(""),
                 .governor = meta.text("host_governor").value_or(""),
                 .clock_source = meta.text("host_clock_source").value_or(""),
                 .cpu_count = static_cast<int>(*cpu_count),
                 .steal = *steal};
  header.real_time = *real_time != 0;
  header.slack = meta.real("slack");
  header.stealing = meta.integer("stealing").value_or(1) != 0;  // the first records do not say
  header.started = TimePoint{*started};
  header.warm_up = *warm_up;
  header.note = meta.text("note").value_or("");
  return header;
}

Result<Ending> read_ending(sqlite::Database& database, const Meta& meta, const Header& header) {
  Ending ending;
  ending.closed = meta.integer("complete") == 1;
  if (ending.closed) {
    const auto ended = meta.duration("ended_ns");
    const auto steal = meta.duration("host_steal_end_ns");
    if (!ended || !steal || TimePoint{*ended} < header.started) return damaged(database, "meta");
    ending.ended = TimePoint{*ended};
    ending.stolen = std::max(*steal - header.host.steal, Nanos{0});
    ending.starved = meta.duration("starved_ns").value_or(Nanos{0});  // the first records do not say
    return ending;
  }
  ending.ended = header.started;
  for (const char* last : {"SELECT max(end_ns) FROM runs", "SELECT max(sent_ns) FROM triggers",
                           "SELECT max(at_ns) FROM plans", "SELECT max(at_ns) FROM notices"}) {
    const auto time = one_integer(database, last);
    if (!time) return time.error();
    ending.ended = std::max(ending.ended, TimePoint{Nanos{std::clamp(*time, std::int64_t{0}, kTimeLimit)}});
  }
  return ending;
}

// The columns of runs, the node first; some of them are not in records of earlier versions.
Result<std::string> run_columns(sqlite::Database& database) {
  const auto has = [&](const char* column) {
    return one_integer(database,
                       fmt::format("SELECT count(*) FROM pragma_table_info('runs') WHERE name = '{}'", column));
  };
  const auto has_waits = has("wait_ns");
  if (!has_waits) return has_waits.error();
  const auto has_cpus = has("on_cpu");
  if (!has_cpus) return has_cpus.error();
  return fmt::format("node, number, begin_ns, end_ns, cpu_ns, mode, emitted, {}, {}", *has_waits == 1 ? "wait_ns" : "0",
                     *has_cpus == 1 ? "on_cpu" : "NULL");
}

// Of such a row; the cells say whether it may be used.
Run run_of(Cells& cells, std::size_t nodes) {
  Run run;
  run.node = NodeId{cells.index(0, nodes)};
  run.number = cells.number(1);
  run.begin = cells.time(2);
  run.end = cells.time(3);
  run.cpu = cells.duration(4);
  run.mode = static_cast<std::uint32_t>(cells.integer(5, 0, std::numeric_limits<std::uint32_t>::max()));
  run.emitted = cells.flag(6);
  run.wait = cells.duration(7);
  if (!cells.null(8)) run.on_cpu = static_cast<int>(cells.integer(8, 0, kMaxCores));
  if (run.begin > run.end) cells.refuse();
  return run;
}

// Whether the runs of each node end in the order of their numbers, as those that a writer has written do.
Result<bool> end_in_order(sqlite::Database& database) {
  bool in_order = true;
  std::int64_t node = -1;
  std::int64_t end = 0;
  const Status done =
      database.each_row("SELECT node, end_ns FROM runs ORDER BY node, number", [&](sqlite::Statement& row) -> Status {
        in_order = in_order && (row.integer(0) != node || row.integer(1) >= end);
        node = row.integer(0);
        end = row.integer(1);
        return Done{};
      });
  if (!done) return done.error();
  return in_order;
}

// The runs of a node in the order of their numbers, with what they consumed: both lie in the file in that order, so
// nothing is sorted, and nothing looked up.
class NodeRuns {
 public:
  static Result<NodeRuns> of(sqlite::Database& database, std::size_t nodes, const std::string& columns, NodeId node) {
    auto runs = database.prepare(fmt::format("SELECT {} FROM runs WHERE node = ? ORDER BY number", columns));
    if (!runs) return runs.error();
    auto inputs =
        database.prepare("SELECT run, predecessor, first, last FROM consumed WHERE node = ? ORDER BY run, predecessor");
    if (!inputs) return inputs.error();
    runs->bind(1, node.index());
    inputs->bind(1, node.index());
    return NodeRuns(database, nodes, std::move(*runs), std::move(*inputs));
  }

  // Moves to the next run, the first one at first; false at the end.
  Result<bool> next() {
    const Result<bool> row = runs_.next();
    if (!row || !*row) return row;
    Cells cells(runs_);
    run_ = run_of(cells, nodes_);
    if (!cells.ok()) return damaged(*database_, "runs");
    while (true) {
      if (!input_ && !inputs_ended_) {
        if (Status done = fetch_input(); !done) return done.error();
      }
      if (inputs_ended_ || input_run_ > run_.number) return true;
      if (input_run_ == run_.number) {
        if (input_->first > input_->last) return damaged(*database_, "consumed");
        run_.consumed.push_back(*input_);
      }
      input_.reset();
    }
  }
  Run& run() { return run_; }

 private:
  NodeRuns(const sqlite::Database& database, std::size_t nodes, sqlite::Statement runs, sqlite::Statement inputs)
      : database_(&database), nodes_(nodes), runs_(std::move(runs)), inputs_(std::move(inputs)) {}

  Status fetch_input() {
    const Result<bool> row = inputs_.next();
    if (!row) return row.error();
    inputs_ended_ = !*row;
    if (inputs_ended_) return Done{};
    Cells cells(inputs_);
    input_run_ = cells.number(0);
    input_ = Consumed{NodeId{cells.index(1, nodes_)}, cells.number(2), cells.number(3)};
    if (!cells.ok()) return damaged(*database_, "consumed");
    return Done{};
  }

  const sqlite::Database* database_;
  std::size_t nodes_;  // how many the app has
  sqlite::Statement runs_;
  sqlite::Statement inputs_;
  Run run_;
  std::optional<Consumed> input_;  // the row that the inputs are at
  std::uint64_t input_run_ = 0;
  bool inputs_ended_ = false;
};

using Take = std::function<void(const Run&)>;

// By their ends, and of those that end together by rank. `rank`: by NodeId.
Status merge(std::vector<NodeRuns>& nodes, const std::vector<std::size_t>& rank, const Take& take) {
  struct Next {
    TimePoint end;
    std::size_t rank;
    std::size_t index;  // in nodes
    bool operator>(const Next& other) const { return std::tie(end, rank) > std::tie(other.end, other.rank); }
  };
  std::priority_queue<Next, std::vector<Next>, std::greater<>> next;
  const auto move_on = [&](std::size_t index) -> Status {
    const Result<bool> row = nodes[index].next();
    if (!row) return row.error();
    const Run& run = nodes[index].run();
    if (*row) next.push({run.end, rank[run.node.index()], index});
    return Done{};
  };
  for (std::size_t index = 0; index < nodes.size(); ++index) {
    if (Status done = move_on(index); !done) return done;
  }
  while (!next.empty()) {
    const std::size_t index = next.top().index;
    next.pop();
    take(nodes[index].run());
    if (Status done = move_on(index); !done) return done;
  }
  return Done{};
}

// The same where those of a node are in any order: all of them are held in memory.
Status sort(std::vector<NodeRuns>& nodes, const std::vector<std::size_t>& rank, const Take& take) {
  std::vector<Run> runs;
  for (NodeRuns& of_node : nodes) {
    while (true) {
      const Result<bool> row = of_node.next();
      if (!row) return row.error();
      if (!*row) break;
      runs.push_back(of_node.run());
    }
  }
  std::stable_sort(runs.begin(), runs.end(), [&](const Run& a, const Run& b) {
    return std::pair(a.end, rank[a.node.index()]) < std::pair(b.end, rank[b.node.index()]);
  });
  for (const Run& run : runs) take(run);
  return Done{};
}

// Who consumed a run, for runs that come in the order of the rows: of (predecessor, first, last, node, run), by the
// first two.
class ConsumerCursor {
 public:
  ConsumerCursor(const graph::Graph& graph, const sqlite::Database& database, sqlite::Statement rows)
      : database_(&database), rows_(std::move(rows)), nodes_(graph.nodes().size()) {}

  Status move_to(const Run& run) {
    std::erase_if(taken_, [&](const Taken& taken) { return !taken.from(run.node) || taken.input.last < run.number; });
    while (true) {
      if (!next_ && !ended_) {
        if (Status done = fetch(); !done) return done;
      }
      if (ended_ || std::pair(next_->input.predecessor, next_->input.first) > std::pair(run.node, run.number)) break;
      const bool takes_it = next_->from(run.node) && next_->input.last >= run.number;
      if (takes_it && taken_.size() < kMaxConsumers) taken_.push_back(*next_);
      next_.reset();
    }
    consumers_.clear();
    for (const Taken& taken : taken_) consumers_.push_back(taken.consumer);
    return Done{};
  }

  std::span<const Consumer> of_run() const { return consumers_; }

 private:
  static constexpr std::size_t kMaxConsumers = 1 << 16;  // a record that was tampered with must not fill the memory

  struct Taken {
    Consumed input;
    Consumer consumer;
    bool from(NodeId node) const { return input.predecessor == node; }
  };

  Status fetch() {
    const Result<bool> row = rows_.next();
    if (!row) return row.error();
    ended_ = !*row;
    if (ended_) return Done{};
    Cells cells(rows_);
    next_ = {{NodeId{cells.index(0, nodes_)}, cells.number(1), cells.number(2)},
             {NodeId{cells.index(3, nodes_)}, cells.number(4)}};
    if (!cells.ok() || next_->input.first > next_->input.last) return damaged(*database_, "consumed");
    return Done{};
  }

  const sqlite::Database* database_;
  sqlite::Statement rows_;
  std::size_t nodes_;          // how many the app has
  std::optional<Taken> next_;  // the row that the cursor is at
  bool ended_ = false;
  std::vector<Taken> taken_;  // that include the run moved to
  std::vector<Consumer> consumers_;
};

}  // namespace

bool looks_like_record(const std::string& path) {
  constexpr std::string_view kBegin = "SQLite format 3";
  std::string begin(kBegin.size(), '\0');
  std::ifstream bytes(path, std::ios::binary);
  return bytes.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == kBegin;
}

struct Reader::Impl {
  static Result<Reader> read(Result<sqlite::Database> database);

  mutable sqlite::Database database;
  graph::App app;
  Header header;
  Ending ending;

  // One a node that has any runs, in the order of their ids.
  Result<std::vector<NodeRuns>> runs_by_node() const;
  Status each_row(const std::string& table, const std::string& columns_and_order,
                  const std::function<void(Cells&)>& take) const;
};

Reader::Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;
Reader::~Reader() = default;

const graph::App& Reader::app() const { return impl_->app; }
const Header& Reader::header() const { return impl_->header; }
const Ending& Reader::ending() const { return impl_->ending; }

Result<Reader> Reader::open(const std::string& path) { return Impl::read(open_record(path)); }

Result<Reader> Reader::of_image(std::span<const std::byte> image) { return Impl::read(open_record(image)); }

Result<Reader> Reader::Impl::read(Result<sqlite::Database> database) {
  if (!database) return database.error();
  const auto meta = Meta::read(*database);
  if (!meta) return meta.error();
  auto app = read_app(*database, *meta);
  if (!app) return app.error();
  auto header = read_header(*database, *meta);
  if (!header) return header.error();
  auto ending = read_ending(*database, *meta, *header);
  if (!ending) return ending.error();
  return Reader(std::make_unique<Impl>(Impl{std::move(*database), std::move(*app), std::move(*header), *ending}));
}

Status Reader::each_run(const std::function<void(const Run&)>& take) const {
  const Result<bool> in_order = end_in_order(impl_->database);
  if (!in_order) return in_order.error();
  auto nodes = impl_->runs_by_node();
  if (!nodes) return nodes.error();
  const graph::Graph& graph = impl_->app.graph;
  std::vector<std::size_t> rank(graph.nodes().size());  // of runs that end together, what is consumed comes first
  for (std::size_t i = 0; i < graph.topological_order().size(); ++i) rank[graph.topological_order()[i].index()] = i;
  return *in_order ? merge(*nodes, rank, take) : sort(*nodes, rank, take);
}

Status Reader::each_run_by_begin(const std::function<void(const Run&)>& take) const {
  const auto columns = run_columns(impl_->database);
  if (!columns) return columns.error();
  return impl_->each_row("runs", *columns + " FROM runs ORDER BY begin_ns, end_ns DESC", [&](Cells& cells) {
    const Run run = run_of(cells, impl_->app.graph.nodes().size());
    if (cells.ok()) take(run);
  });
}

Status Reader::each_run_with_consumers(const std::function<void(const Run&, std::span<const Consumer>)>& take) const {
  auto rows = impl_->database.prepare(
      "SELECT predecessor, first, last, node, run FROM consumed ORDER BY predecessor, first, node, run");
  if (!rows) return rows.error();
  ConsumerCursor consumers(impl_->app.graph, impl_->database, std::move(*rows));
  auto nodes = impl_->runs_by_node();
  if (!nodes) return nodes.error();
  for (NodeRuns& runs : *nodes) {
    while (true) {
      const Result<bool> row = runs.next();
      if (!row) return row.error();
      if (!*row) break;
      if (Status done = consumers.move_to(runs.run()); !done) return done;
      take(runs.run(), consumers.of_run());
    }
  }
  return Done{};
}

Status Reader::each_trigger(const std::function<void(const Trigger&)>& take) const {
  const std::string rows = "subchain, number, due_ns, sent_ns FROM triggers ORDER BY subchain, number";
  return impl_->each_row("triggers", rows, [&](Cells& cells) {
    Trigger trigger;
    trigger.subchain = SubchainId{cells.index(0, impl_->app.graph.subchains().size())};
    trigger.number = cells.number(1);
    trigger.due = cells.time(2);
    trigger.sent = cells.time(3);
    if (cells.ok()) take(trigger);
  });
}

Status Reader::each_slot(const std::function<void(const SlotUse&)>& take) const {
  const std::string rows = "core, subchain, planned_ns, begin_ns, end_ns FROM slots ORDER BY id";
  return impl_->each_row("slots", rows, [&](Cells& cells) {
    SlotUse slot;
    slot.core = static_cast<int>(cells.integer(0, 0, kMaxCores));
    slot.subchain = SubchainId{cells.index(1, impl_->app.graph.subchains().size())};
    slot.planned = cells.time(2);
    slot.begin = cells.time(3);
    slot.end = cells.time(4);
    if (cells.ok()) take(slot);
  });
}

Status Reader::each_steal(const std::function<void(const Steal&)>& take) const {
  const std::string rows = "core, thief, victim, begin_ns, end_ns FROM steals ORDER BY id";
  return impl_->each_row("steals", rows, [&](Cells& cells) {
    const std::size_t subchains = impl_->app.graph.subchains().size();
    Steal steal;
    steal.core = static_cast<int>(cells.integer(0, 0, kMaxCores));
    steal.thief = SubchainId{cells.index(1, subchains)};
    steal.victim = SubchainId{cells.index(2, subchains)};
    steal.begin = cells.time(3);
    steal.end = cells.time(4);
    if (cells.ok()) take(steal);
  });
}

Status Reader::each_overrun(const std::function<void(const Overrun&)>& take) const {
  const std::string rows = "subchain, number, at_ns, cpu_ns FROM overruns ORDER BY id";
  return impl_->each_row("overruns", rows, [&](Cells& cells) {
    Overrun overrun;
    overrun.subchain = SubchainId{cells.index(0, impl_->app.graph.subchains().size())};
    overrun.number = cells.number(1);
    overrun.at = cells.time(2);
    overrun.cpu = cells.duration(3);
    if (cells.ok()) take(overrun);
  });
}

Result<std::vector<PlanChange>> Reader::plans() const {
  std::vector<PlanChange> plans;
  const auto done = impl_->each_row("plans", "at_ns, reason, json FROM plans ORDER BY id", [&](Cells& cells) {
    plans.push_back({cells.time(0), cells.text(1), cells.text(2)});
  });
  if (!done) return done.error();
  return plans;
}

Result<std::vector<CostChange>> Reader::cost_changes() const {
  std::vector<CostChange> changes;
  const auto tables = one_integer(impl_->database, "SELECT count(*) FROM sqlite_master WHERE name = 'cost_changes'");
  if (!tables) return tables.error();
  if (*tables == 0) return changes;
  const std::string rows = "at_ns, node, mode, core_kind, before_ns, after_ns, runs FROM cost_changes ORDER BY id";
  const auto done = impl_->each_row("cost_changes", rows, [&](Cells& cells) {
    CostChange change;
    change.at = cells.time(0);
    change.node = NodeId{cells.index(1, impl_->app.graph.nodes().size())};
    change.mode = static_cast<std::uint32_t>(cells.integer(2, 0, std::numeric_limits<std::uint32_t>::max()));
    change.core_kind = static_cast<int>(cells.integer(3, 0, kMaxCores));
    change.before = cells.duration(4);
    change.after = cells.duration(5);
    change.runs = cells.number(6);
    if (cells.ok()) changes.push_back(change);
  });
  if (!done) return done.error();
  return changes;
}

Result<std::vector<ClockReading>> Reader::clocks() const {
  std::vector<ClockReading> clocks;
  const std::string rows = "at_ns, node, tick_ns, period_ns FROM clocks ORDER BY id";
  const auto done = impl_->each_row("clocks", rows, [&](Cells& cells) {
    ClockReading reading;
    reading.at = cells.time(0);
    reading.node = NodeId{cells.index(1, impl_->app.graph.nodes().size())};
    reading.ticks = {cells.time(2), cells.duration(3)};
    if (cells.ok() && (reading.ticks.period <= Nanos{0} || !impl_->app.graph.node(reading.node).has_clock()))
      cells.refuse();
    if (cells.ok()) clocks.push_back(reading);
  });
  if (!done) return done.error();
  return clocks;
}

Result<std::vector<AppChange>> Reader::app_changes() const {
  std::vector<AppChange> changes;
  const std::string rows = "at_ns, what, item, before, after FROM app_changes ORDER BY id";
  const auto done = impl_->each_row("app_changes", rows, [&](Cells& cells) {
    const auto value = [&](int column) {
      return cells.null(column) ? std::nullopt : std::optional(cells.real(column));
    };
    AppChange change;
    change.at = cells.time(0);
    const std::optional<AppChange::What> what = change_named(cells.text(1));
    if (!what) return cells.refuse();
    change.what = *what;
    const std::size_t items =
        *what == AppChange::What::kMinRate ? impl_->app.graph.nodes().size() : impl_->app.objective.size();
    change.item = cells.index(2, items);
    change.before = value(3);
    change.after = value(4);
    if (*what == AppChange::What::kWeight && !change.after) cells.refuse();
    if (cells.ok()) changes.push_back(change);
  });
  if (!done) return done.error();
  return changes;
}

Result<std::vector<Notice>> Reader::notices() const {
  std::vector<Notice> notices;
  const auto done = impl_->each_row("notices", "at_ns, kind, detail FROM notices ORDER BY id", [&](Cells& cells) {
    notices.push_back({cells.time(0), cells.text(1), cells.text(2)});
  });
  if (!done) return done.error();
  return notices;
}

Result<std::vector<NodeRuns>> Reader::Impl::runs_by_node() const {
  const auto columns = run_columns(database);
  if (!columns) return columns.error();
  auto above = database.prepare("SELECT min(node) FROM runs WHERE node > ?");
  if (!above) return above.error();
  std::vector<NodeRuns> nodes;
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  while (true) {
    above->bind(1, last);
    const Result<bool> row = above->next();
    if (!row) return row.error();
    Cells cells(*above);
    if (cells.null(0)) return nodes;
    const NodeId node{cells.index(0, app.graph.nodes().size())};
    if (!cells.ok()) return damaged(database, "runs");
    last = static_cast<std::int64_t>(node.index());
    above->reset();
    auto runs = NodeRuns::of(database, app.graph.nodes().size(), *columns, node);
    if (!runs) return runs.error();
    nodes.push_back(std::move(*runs));
  }
}

Status Reader::Impl::each_row(const std::string& table, const std::string& columns_and_order,
                              const std::function<void(Cells&)>& take) const {
  return database.each_row("SELECT " + columns_and_order, [&](sqlite::Statement& row) -> Status {
    Cells cells(row);
    take(cells);
    if (!cells.ok()) return damaged(database, table);
    return Done{};
  });
}

}  // namespace ctn::record
