// The tables of a record, as the writer makes and the reader expects them. docs/record-schema.md explains each column.
// A change of meaning raises kSchemaVersion; a reader refuses records of a newer version.
#pragma once

namespace ctn::record {

constexpr int kApplicationId = 0x4341544E;  // "CATN": tells `file` and the reader what this database is
constexpr int kSchemaVersion = 1;

inline constexpr const char* kSchema = R"sql(
CREATE TABLE meta(key TEXT NOT NULL PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE nodes(
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  input TEXT NOT NULL,
  external INTEGER NOT NULL,
  unscheduled INTEGER NOT NULL,
  period_ns INTEGER,
  output_period_ns INTEGER,
  min_rate_hz REAL,
  max_rate_hz REAL,
  fallback_rate_hz REAL,
  max_threads INTEGER NOT NULL,
  needs_input INTEGER NOT NULL
);
CREATE TABLE modes(
  node INTEGER NOT NULL, mode INTEGER NOT NULL, name TEXT NOT NULL, PRIMARY KEY(node, mode)
) WITHOUT ROWID;
CREATE TABLE core_kinds(id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, count INTEGER NOT NULL, speed REAL NOT NULL);
CREATE TABLE edges(id INTEGER PRIMARY KEY, from_node INTEGER NOT NULL, to_node INTEGER NOT NULL);
CREATE TABLE age_limits(edge INTEGER PRIMARY KEY, max_age_ns INTEGER NOT NULL, on_stale TEXT NOT NULL);
CREATE TABLE exclusive(
  id INTEGER NOT NULL, position INTEGER NOT NULL, name TEXT NOT NULL, node INTEGER NOT NULL, PRIMARY KEY(id, position)
) WITHOUT ROWID;
CREATE TABLE subchains(
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  implicit INTEGER NOT NULL,
  slot_order INTEGER NOT NULL,
  steal_rank INTEGER NOT NULL,
  steals INTEGER NOT NULL
);
CREATE TABLE subchain_nodes(
  subchain INTEGER NOT NULL, position INTEGER NOT NULL, node INTEGER NOT NULL, PRIMARY KEY(subchain, position)
) WITHOUT ROWID;
CREATE TABLE chains(id INTEGER PRIMARY KEY, metric TEXT NOT NULL, weight REAL NOT NULL, max_ns INTEGER);
CREATE TABLE chain_nodes(
  chain INTEGER NOT NULL, position INTEGER NOT NULL, node INTEGER NOT NULL, PRIMARY KEY(chain, position)
) WITHOUT ROWID;
CREATE TABLE runs(
  node INTEGER NOT NULL,
  number INTEGER NOT NULL,
  begin_ns INTEGER NOT NULL,
  end_ns INTEGER NOT NULL,
  cpu_ns INTEGER NOT NULL,
  mode INTEGER NOT NULL,
  emitted INTEGER NOT NULL,
  wait_ns INTEGER NOT NULL,
  on_cpu INTEGER,
  PRIMARY KEY(node, number)
) WITHOUT ROWID;
CREATE TABLE consumed(
  node INTEGER NOT NULL,
  run INTEGER NOT NULL,
  predecessor INTEGER NOT NULL,
  first INTEGER NOT NULL,
  last INTEGER NOT NULL,
  PRIMARY KEY(node, run, predecessor)
) WITHOUT ROWID;
CREATE TABLE triggers(
  subchain INTEGER NOT NULL,
  number INTEGER NOT NULL,
  due_ns INTEGER NOT NULL,
  sent_ns INTEGER NOT NULL,
  PRIMARY KEY(subchain, number)
) WITHOUT ROWID;
CREATE TABLE slots(
  id INTEGER PRIMARY KEY,
  core INTEGER NOT NULL,
  subchain INTEGER NOT NULL,
  planned_ns INTEGER NOT NULL,
  begin_ns INTEGER NOT NULL,
  end_ns INTEGER NOT NULL
);
CREATE TABLE steals(
  id INTEGER PRIMARY KEY,
  core INTEGER NOT NULL,
  thief INTEGER NOT NULL,
  victim INTEGER NOT NULL,
  begin_ns INTEGER NOT NULL,
  end_ns INTEGER NOT NULL
);
CREATE TABLE overruns(
  id INTEGER PRIMARY KEY,
  subchain INTEGER NOT NULL,
  number INTEGER NOT NULL,
  at_ns INTEGER NOT NULL,
  cpu_ns INTEGER NOT NULL
);
CREATE TABLE plans(id INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, reason TEXT NOT NULL, json TEXT NOT NULL);
CREATE TABLE cost_changes(
  id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  node INTEGER NOT NULL,
  mode INTEGER NOT NULL,
  core_kind INTEGER NOT NULL,
  before_ns INTEGER NOT NULL,
  after_ns INTEGER NOT NULL,
  runs INTEGER NOT NULL
);
CREATE TABLE app_changes(
  id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  what TEXT NOT NULL,
  item INTEGER NOT NULL,
  before REAL,
  after REAL
);
CREATE TABLE clocks(
  id INTEGER PRIMARY KEY,
  at_ns INTEGER NOT NULL,
  node INTEGER NOT NULL,
  tick_ns INTEGER NOT NULL,
  period_ns INTEGER NOT NULL
);
CREATE TABLE notices(id INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, kind TEXT NOT NULL, detail TEXT NOT NULL);
)sql";

}  // namespace ctn::record
