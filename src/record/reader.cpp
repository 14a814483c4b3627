#include "record/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <limits>
#include <string_view>

#include "record/app_changes.h"
#include "record/app_tables.h"
#include "record/cells.h"
#include "record/meta.h"
#include "record/open_record.h"
#include "record/sqlite.h"
#include "record/stored_runs.h"

namespace ctn::record {
namespace {

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
  std::function<void(std::uint64_t)> tell{};
  mutable std::uint64_t handed_on = 0;

  // One more event is about to be.
  void count() const {
    constexpr std::uint64_t kBetween = 4096;
    if (++handed_on % kBetween == 0 && tell) tell(handed_on);
  }
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

void Reader::on_progress(std::function<void(std::uint64_t)> tell) { impl_->tell = std::move(tell); }

Status Reader::each_run(const std::function<void(const Run&)>& take) const {
  return each_stored_run(impl_->database, impl_->app.graph, [&](const Run& run) {
    impl_->count();
    take(run);
  });
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
  auto nodes = runs_by_node(impl_->database, impl_->app.graph.nodes().size());
  if (!nodes) return nodes.error();
  for (NodeRuns& runs : *nodes) {
    while (true) {
      const Result<bool> row = runs.next();
      if (!row) return row.error();
      if (!*row) break;
      if (Status done = consumers.move_to(runs.run()); !done) return done;
      impl_->count();
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

Status Reader::Impl::each_row(const std::string& table, const std::string& columns_and_order,
                              const std::function<void(Cells&)>& take) const {
  return database.each_row("SELECT " + columns_and_order, [&](sqlite::Statement& row) -> Status {
    Cells cells(row);
    count();
    take(cells);
    if (!cells.ok()) return damaged(database, table);
    return Done{};
  });
}

}  // namespace ctn::record
