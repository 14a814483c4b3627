#include "record/stored_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <queue>
#include <tuple>

#include "record/open_record.h"

namespace ctn::record {
namespace {

using Take = std::function<void(const Run&)>;

constexpr std::size_t kMaxConsumers = 1 << 16;  // a record that was tampered with must not fill the memory

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

}  // namespace

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

Result<NodeRuns> NodeRuns::of(sqlite::Database& database, std::size_t nodes, const std::string& columns, NodeId node) {
  auto runs = database.prepare(fmt::format("SELECT {} FROM runs WHERE node = ? ORDER BY number", columns));
  if (!runs) return runs.error();
  auto inputs =
      database.prepare("SELECT run, predecessor, first, last FROM consumed WHERE node = ? ORDER BY run, predecessor");
  if (!inputs) return inputs.error();
  runs->bind(1, node.index());
  inputs->bind(1, node.index());
  return NodeRuns(database, nodes, std::move(*runs), std::move(*inputs));
}

Result<bool> NodeRuns::next() {
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

Status NodeRuns::fetch_input() {
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

Result<std::vector<NodeRuns>> runs_by_node(sqlite::Database& database, std::size_t nodes) {
  const auto columns = run_columns(database);
  if (!columns) return columns.error();
  auto above = database.prepare("SELECT min(node) FROM runs WHERE node > ?");
  if (!above) return above.error();
  std::vector<NodeRuns> all;
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  while (true) {
    above->bind(1, last);
    const Result<bool> row = above->next();
    if (!row) return row.error();
    Cells cells(*above);
    if (cells.null(0)) return all;
    const NodeId node{cells.index(0, nodes)};
    if (!cells.ok()) return damaged(database, "runs");
    last = static_cast<std::int64_t>(node.index());
    above->reset();
    auto runs = NodeRuns::of(database, nodes, *columns, node);
    if (!runs) return runs.error();
    all.push_back(std::move(*runs));
  }
}

Status each_stored_run(sqlite::Database& database, const graph::Graph& graph, const Take& take) {
  const Result<bool> in_order = end_in_order(database);
  if (!in_order) return in_order.error();
  auto nodes = runs_by_node(database, graph.nodes().size());
  if (!nodes) return nodes.error();
  std::vector<std::size_t> rank(graph.nodes().size());
  for (std::size_t i = 0; i < graph.topological_order().size(); ++i) rank[graph.topological_order()[i].index()] = i;
  return *in_order ? merge(*nodes, rank, take) : sort(*nodes, rank, take);
}

Status ConsumerCursor::move_to(const Run& run) {
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

Status ConsumerCursor::fetch() {
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

}  // namespace ctn::record
