// The runs of a record as they lie in its tables, and who consumed them: read row by row, each checked, so that a
// record may have more runs than fit into the memory.
//
// Errors of all: a row that cannot be; a file that cannot be read.
// Thread safety: none; as the database's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/result.h"
#include "graph/app.h"
#include "record/cells.h"
#include "record/events.h"
#include "record/sqlite.h"

namespace ctn::record {

// No core of a record has a higher number.
constexpr int kMaxCores = 1 << 20;

// The columns of runs, the node first; some of them are not in records of earlier versions.
Result<std::string> run_columns(sqlite::Database& database);
// Of such a row; the cells say whether it may be used.
Run run_of(Cells& cells, std::size_t nodes);

// The runs of a node in the order of their numbers, with what they consumed: both lie in the file in that order, so
// nothing is sorted, and nothing looked up.
class NodeRuns {
 public:
  // `nodes`: how many the app has. `columns`: run_columns().
  static Result<NodeRuns> of(sqlite::Database& database, std::size_t nodes, const std::string& columns, NodeId node);

  // Moves to the next run, the first one at first; false at the end.
  Result<bool> next();
  Run& run() { return run_; }

 private:
  NodeRuns(const sqlite::Database& database, std::size_t nodes, sqlite::Statement runs, sqlite::Statement inputs)
      : database_(&database), nodes_(nodes), runs_(std::move(runs)), inputs_(std::move(inputs)) {}

  Status fetch_input();

  const sqlite::Database* database_;
  std::size_t nodes_;
  sqlite::Statement runs_;
  sqlite::Statement inputs_;
  Run run_;
  std::optional<Consumed> input_;  // the row that the inputs are at
  std::uint64_t input_run_ = 0;
  bool inputs_ended_ = false;
};

// One a node that has any runs, in the order of their ids.
Result<std::vector<NodeRuns>> runs_by_node(sqlite::Database& database, std::size_t nodes);

// By their ends; of runs that end together, what is consumed comes first.
Status each_stored_run(sqlite::Database& database, const graph::Graph& graph,
                       const std::function<void(const Run&)>& take);

// Who consumed a run, for runs that come in the order of the rows: of (predecessor, first, last, node, run), by the
// first two.
class ConsumerCursor {
 public:
  ConsumerCursor(const graph::Graph& graph, const sqlite::Database& database, sqlite::Statement rows)
      : database_(&database), rows_(std::move(rows)), nodes_(graph.nodes().size()) {}

  Status move_to(const Run& run);
  std::span<const Consumer> of_run() const { return consumers_; }

 private:
  struct Taken {
    Consumed input;
    Consumer consumer;
    bool from(NodeId node) const { return input.predecessor == node; }
  };

  Status fetch();

  const sqlite::Database* database_;
  sqlite::Statement rows_;
  std::size_t nodes_;          // how many the app has
  std::optional<Taken> next_;  // the row that the cursor is at
  bool ended_ = false;
  std::vector<Taken> taken_;  // that include the run moved to
  std::vector<Consumer> consumers_;
};

}  // namespace ctn::record
