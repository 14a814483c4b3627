#include "record/writer.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "record/app_changes.h"
#include "record/app_tables.h"
#include "record/meta.h"
#include "record/schema.h"
#include "record/sqlite.h"

namespace ctn::record {
namespace {

constexpr std::size_t kBatch = 1 << 13;    // events after which a flush is made unasked
constexpr std::size_t kMaxHeld = 1 << 20;  // events that wait in memory while another program holds the file
constexpr std::chrono::milliseconds kFlushWait{100};
constexpr std::chrono::milliseconds kCloseWait{5000};

std::int64_t ns(TimePoint time) { return time.time_since_epoch().count(); }

// Makes an empty file where none was.
Status claim(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "wxe");
  if (file != nullptr) {
    std::fclose(file);
    return Done{};
  }
  if (errno == EEXIST) return Error::caller(path + " exists already", "name a file that does not exist");
  return Error::environment(fmt::format("{} cannot be made: {}", path, std::strerror(errno)),
                            "name a file in a folder that is there and may be written");
}

Status write_header(sqlite::Database& database, const Header& header) {
  auto meta = MetaWriter::prepare(database);
  if (!meta) return meta.error();
  const std::string cpus = os::to_string(header.cpus);
  meta->set("scheduler", std::string_view(header.scheduler))
      .set("note", std::string_view(header.note))
      .set("cpus", std::string_view(cpus))
      .set("real_time", header.real_time)
      .set("slack", header.slack)
      .set("stealing", header.stealing)
      .set("started_ns", ns(header.started))
      .set("started_utc", std::string_view(header.host.utc))
      .set("warm_up_ns", header.warm_up.count())
      .set("complete", false)
      .set("host_kernel", std::string_view(header.host.kernel))
      .set("host_cpu_model", std::string_view(header.host.cpu_model))
      .set("host_governor", std::string_view(header.host.governor))
      .set("host_clock_source", std::string_view(header.host.clock_source))
      .set("host_cpu_count", header.host.cpu_count)
      .set("host_steal_ns", header.host.steal.count());
  return meta->status();
}

// One file with its tables, the app and the header, or nothing.
Status lay_out(sqlite::Database& database, const graph::App& app, const Header& header) {
  // A rollback journal, not a write-ahead log: after a kill the one file is the record, and copying it copies all of
  // it. The price is that a reader and a commit wait for each other; a batch a second makes that cheap.
  // All in one transaction, so that there is never half a schema.
  const std::string begin = fmt::format(
      "PRAGMA journal_mode = DELETE; PRAGMA synchronous = FULL; BEGIN EXCLUSIVE; PRAGMA application_id = {}; "
      "PRAGMA user_version = {};",
      kApplicationId, kSchemaVersion);
  if (auto done = database.execute(begin); !done) return done;
  if (auto done = database.execute(kSchema); !done) return done;
  if (auto done = write_app(database, app); !done) return done;
  if (auto done = write_header(database, header); !done) return done;
  return database.execute("COMMIT");
}

struct Statements {
  sqlite::Statement run;
  sqlite::Statement consumed;
  sqlite::Statement trigger;
  sqlite::Statement slot;
  sqlite::Statement steal;
  sqlite::Statement overrun;
  sqlite::Statement plan;
  sqlite::Statement cost_change;
  sqlite::Statement app_change;
  sqlite::Statement clock;
  sqlite::Statement notice;
};

Result<Statements> prepare(sqlite::Database& database) {
  auto run = database.prepare("INSERT INTO runs VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!run) return run.error();
  auto consumed = database.prepare("INSERT INTO consumed VALUES (?, ?, ?, ?, ?)");
  if (!consumed) return consumed.error();
  auto trigger = database.prepare("INSERT INTO triggers VALUES (?, ?, ?, ?)");
  if (!trigger) return trigger.error();
  auto slot =
      database.prepare("INSERT INTO slots(core, subchain, planned_ns, begin_ns, end_ns) VALUES (?, ?, ?, ?, ?)");
  if (!slot) return slot.error();
  auto steal = database.prepare("INSERT INTO steals(core, thief, victim, begin_ns, end_ns) VALUES (?, ?, ?, ?, ?)");
  if (!steal) return steal.error();
  auto overrun = database.prepare("INSERT INTO overruns(subchain, number, at_ns, cpu_ns) VALUES (?, ?, ?, ?)");
  if (!overrun) return overrun.error();
  auto plan = database.prepare("INSERT INTO plans(at_ns, reason, json) VALUES (?, ?, ?)");
  if (!plan) return plan.error();
  auto cost_change = database.prepare(
      "INSERT INTO cost_changes(at_ns, node, mode, core_kind, before_ns, after_ns, runs) VALUES (?, ?, ?, ?, ?, ?, ?)");
  if (!cost_change) return cost_change.error();
  auto app_change =
      database.prepare("INSERT INTO app_changes(at_ns, what, item, before, after) VALUES (?, ?, ?, ?, ?)");
  if (!app_change) return app_change.error();
  auto clock = database.prepare("INSERT INTO clocks(at_ns, node, tick_ns, period_ns) VALUES (?, ?, ?, ?)");
  if (!clock) return clock.error();
  auto notice = database.prepare("INSERT INTO notices(at_ns, kind, detail) VALUES (?, ?, ?)");
  if (!notice) return notice.error();
  return Statements{std::move(*run),        std::move(*consumed), std::move(*trigger), std::move(*slot),
                    std::move(*steal),      std::move(*overrun),  std::move(*plan),    std::move(*cost_change),
                    std::move(*app_change), std::move(*clock),    std::move(*notice)};
}

class SqliteWriter : public Writer {
 public:
  SqliteWriter(sqlite::Database database, Statements statements)
      : database_(std::move(database)), statements_(std::move(statements)) {
    database_->set_busy_timeout(kFlushWait);
  }
  ~SqliteWriter() override {
    if (database_) (void)flush();
  }

  void add(const Run& run) override { hold(runs_, run); }
  void add(const Trigger& trigger) override { hold(triggers_, trigger); }
  void add(const SlotUse& slot) override { hold(slots_, slot); }
  void add(const Steal& steal) override { hold(steals_, steal); }
  void add(const Overrun& overrun) override { hold(overruns_, overrun); }
  void add(const PlanChange& change) override { hold(plans_, change); }
  void add(const CostChange& change) override { hold(cost_changes_, change); }
  void add(const AppChange& change) override { hold(app_changes_, change); }
  void add(const ClockReading& reading) override { hold(clocks_, reading); }
  void add(const Notice& notice) override { hold(notices_, notice); }
  void set_totals(const Totals& totals) override { totals_ = totals; }

  void begin_at(TimePoint started, Nanos warm_up) override { began_ = Began{started, warm_up}; }

  Status flush() override {
    if (!status_ || !database_ || held() == 0) return status_;
    (void)commit([] { return Status(Done{}); });
    return status_;
  }

  Status close(TimePoint ended, const os::HostFacts& host) override {
    if (!database_) return status_;
    if (status_) {
      database_->set_busy_timeout(kCloseWait);
      const Status done = commit([&] { return write_footer(ended, host); });
      if (!done && status_) fail(done);  // deferred: there is no later
    }
    statements_.reset();
    database_.reset();
    return status_;
  }

 private:
  struct Began {
    TimePoint started{};
    Nanos warm_up{0};
  };

  template <class Event>
  void hold(std::vector<Event>& events, const Event& event) {
    if (!status_ || !database_) return;
    events.push_back(event);
    if (held() % kBatch == 0) (void)flush();
  }
  std::size_t held() const {
    return runs_.size() + triggers_.size() + slots_.size() + steals_.size() + overruns_.size() + plans_.size() +
           cost_changes_.size() + app_changes_.size() + clocks_.size() + notices_.size();
  }

  Status write_footer(TimePoint ended, const os::HostFacts& host) {
    auto meta = MetaWriter::prepare(*database_);
    if (!meta) return meta.error();
    if (began_) meta->set("started_ns", ns(began_->started)).set("warm_up_ns", began_->warm_up.count());
    meta->set("ended_ns", ns(ended))
        .set("host_steal_end_ns", host.steal.count())
        .set("plans_made", totals_.plans_made)
        .set("planning_cpu_ns", totals_.planning_cpu.count())
        .set("starved", totals_.starved)
        .set("starved_ns", totals_.starved_for.count())
        .set("complete", true);
    return meta->status();
  }

  // Writes all that is held, and what `also` writes, or nothing. Where another program holds the file, what is held
  // stays for the next time.
  Status commit(const std::function<Status()>& also) {
    Status done = database_->execute("BEGIN IMMEDIATE");
    if (done) done = write_held();
    if (done) done = also();
    if (done) done = database_->execute("COMMIT");
    if (done) {
      forget_held();
      return done;
    }
    const bool busy = database_->busy();
    if (database_->in_transaction()) (void)database_->execute("ROLLBACK");
    if (!busy || held() >= kMaxHeld) fail(done);
    return done;
  }

  void fail(const Status& why) {
    status_ = why;
    forget_held();
  }
  void forget_held() {
    runs_.clear();
    triggers_.clear();
    slots_.clear();
    steals_.clear();
    overruns_.clear();
    plans_.clear();
    cost_changes_.clear();
    app_changes_.clear();
    clocks_.clear();
    notices_.clear();
  }

  Status write_held() {
    for (const Run& run : runs_) {
      if (auto done = write(run); !done) return done;
    }
    for (const Trigger& trigger : triggers_) {
      const auto done =
          statements_->trigger.run(trigger.subchain.index(), trigger.number, ns(trigger.due), ns(trigger.sent));
      if (!done) return done;
    }
    for (const SlotUse& slot : slots_) {
      const auto done =
          statements_->slot.run(slot.core, slot.subchain.index(), ns(slot.planned), ns(slot.begin), ns(slot.end));
      if (!done) return done;
    }
    for (const Steal& steal : steals_) {
      const auto done =
          statements_->steal.run(steal.core, steal.thief.index(), steal.victim.index(), ns(steal.begin), ns(steal.end));
      if (!done) return done;
    }
    for (const Overrun& overrun : overruns_) {
      const auto done =
          statements_->overrun.run(overrun.subchain.index(), overrun.number, ns(overrun.at), overrun.cpu.count());
      if (!done) return done;
    }
    for (const PlanChange& change : plans_) {
      const auto done =
          statements_->plan.run(ns(change.at), std::string_view(change.reason), std::string_view(change.json));
      if (!done) return done;
    }
    for (const CostChange& change : cost_changes_) {
      const auto done = statements_->cost_change.run(ns(change.at), change.node.index(), change.mode, change.core_kind,
                                                     change.before.count(), change.after.count(), change.runs);
      if (!done) return done;
    }
    for (const AppChange& change : app_changes_) {
      const auto done = statements_->app_change.run(ns(change.at), std::string_view(to_string(change.what)),
                                                    change.item, change.before, change.after);
      if (!done) return done;
    }
    for (const ClockReading& reading : clocks_) {
      const auto done = statements_->clock.run(ns(reading.at), reading.node.index(), ns(reading.ticks.tick),
                                               reading.ticks.period.count());
      if (!done) return done;
    }
    for (const Notice& notice : notices_) {
      const auto done =
          statements_->notice.run(ns(notice.at), std::string_view(notice.kind), std::string_view(notice.detail));
      if (!done) return done;
    }
    return Done{};
  }

  Status write(const Run& run) {
    auto done =
        statements_->run.run(run.node.index(), run.number, ns(run.begin), ns(run.end), run.cpu.count(), run.mode,
                             run.emitted, run.wait.count(), run.on_cpu < 0 ? std::nullopt : std::optional(run.on_cpu));
    if (!done) return done;
    for (const Consumed& input : run.consumed) {
      done =
          statements_->consumed.run(run.node.index(), run.number, input.predecessor.index(), input.first, input.last);
      if (!done) return done;
    }
    return done;
  }

  std::optional<sqlite::Database> database_;  // none: closed
  std::optional<Statements> statements_;      // after the database: must go first
  std::vector<Run> runs_;
  std::vector<Trigger> triggers_;
  std::vector<SlotUse> slots_;
  std::vector<Steal> steals_;
  std::vector<Overrun> overruns_;
  std::vector<PlanChange> plans_;
  std::vector<CostChange> cost_changes_;
  std::vector<AppChange> app_changes_;
  std::vector<ClockReading> clocks_;
  std::vector<Notice> notices_;
  Totals totals_;
  std::optional<Began> began_;  // in place of what the header says
  Status status_ = Done{};      // the first failure
};

}  // namespace

Result<std::vector<std::byte>> Writer::blank(const graph::App& app, const Header& header) {
  auto database = sqlite::Database::in_memory();
  if (!database) return database.error();
  if (auto done = lay_out(*database, app, header); !done) return done.error();
  return database->image();
}

Result<std::unique_ptr<Writer>> Writer::create(const std::string& path, const graph::App& app, const Header& header) {
  if (auto done = claim(path); !done) return done.error();
  const auto give_up = [&](const Error& error) {
    std::remove(path.c_str());  // nothing half-made stays
    return error;
  };
  auto database = sqlite::Database::open(path, SQLITE_OPEN_READWRITE);
  if (!database) return give_up(database.error());
  if (auto done = lay_out(*database, app, header); !done) return give_up(done.error());
  auto statements = prepare(*database);
  if (!statements) return give_up(statements.error());
  return std::unique_ptr<Writer>(new SqliteWriter(std::move(*database), std::move(*statements)));
}

}  // namespace ctn::record
