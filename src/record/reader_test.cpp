// What a reader makes of files that no writer made: errors, and nothing worse.
#include "record/reader.h"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "record/app_changes.h"
#include "record/lineage.h"
#include "record/schema.h"
#include "record/sqlite.h"
#include "record/testing/record_fixture.h"

namespace ctn::record {
namespace {

using namespace test;
using testing::HasSubstr;

// A complete record with one of everything.
std::string sample_record(const Folder& folder) {
  const graph::App app = robot();
  const std::string path = folder.file("sample");
  const auto writer = make(path, app);
  for (const record::Run& run : runs(app, seconds{103}, 1)) writer->add(run);
  for (std::uint64_t i = 1; i < 4; ++i) {
    writer->add(Trigger{SubchainId{0}, i, at(seconds{103}), at(seconds{103} + microseconds{i})});
  }
  writer->add(SlotUse{0, SubchainId{1}, at(seconds{103}), at(seconds{103}), at(seconds{104})});
  writer->add(Steal{0, SubchainId{0}, SubchainId{1}, at(seconds{103}), at(seconds{104})});
  writer->add(PlanChange{at(seconds{100}), "bootstrap", "{}"});
  writer->add(Notice{at(seconds{102}), "watchdog", "x"});
  EXPECT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  return path;
}

// Reads all there is, as `catan report` does.
Status read_all(const std::string& path) {
  const auto reader = Reader::open(path);
  if (!reader) return reader.error();
  std::vector<ChainTracker> trackers;
  for (const graph::Term& term : reader->app().objective) trackers.emplace_back(reader->app().graph, term.path);
  auto done = reader->each_run([&](const record::Run& run) {
    for (ChainTracker& tracker : trackers) (void)tracker.add(run);
  });
  if (!done) return done;
  done = reader->each_run_by_begin([](const record::Run&) {});
  if (!done) return done;
  done = reader->each_run_with_consumers([](const record::Run&, std::span<const Consumer>) {});
  if (!done) return done;
  done = reader->each_trigger([](const Trigger&) {});
  if (!done) return done;
  done = reader->each_slot([](const SlotUse&) {});
  if (!done) return done;
  done = reader->each_steal([](const Steal&) {});
  if (!done) return done;
  if (const auto plans = reader->plans(); !plans) return plans.error();
  const auto changes = reader->app_changes();
  if (!changes) return changes.error();
  if (const auto changed = app_after(reader->app(), *changes); !changed) return changed.error();
  if (const auto notices = reader->notices(); !notices) return notices.error();
  return Done{};
}

// The message of the error that a record gives after `sql` changed it; it must be the caller's.
std::string error_after(const std::string& sql) {
  const Folder folder;
  const std::string path = sample_record(folder);
  {
    auto database = sqlite::Database::open(path, SQLITE_OPEN_READWRITE);
    const auto done = database->execute(sql);
    EXPECT_TRUE(done.ok()) << sql << ": " << (done ? "" : done.error().message());
  }
  const Status status = read_all(path);
  if (status) return "";
  EXPECT_EQ(status.error().kind(), ErrorKind::kCaller) << status.error().message();
  return status.error().message();
}

TEST(Reader, TellsHowManyEventsItHasHandedOn) {
  const Folder folder;
  const std::string path = folder.file("long");
  {
    const auto writer = make(path, robot());
    for (std::uint64_t i = 1; i <= 5000; ++i)
      writer->add(Trigger{SubchainId{0}, i, at(seconds{103}), at(seconds{103})});
    ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  }
  auto reader = Reader::open(path);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  std::vector<std::uint64_t> told;
  reader->on_progress([&](std::uint64_t events) { told.push_back(events); });
  for (int pass = 0; pass < 2; ++pass) ASSERT_TRUE(reader->each_trigger([](const Trigger&) {}).ok());
  EXPECT_EQ(told, (std::vector<std::uint64_t>{4096, 8192}));
}

TEST(Reader, SaysThatThereIsNoFile) {
  const auto reader = Reader::open("/no/such/record");
  ASSERT_FALSE(reader.ok());
  EXPECT_EQ(reader.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(reader.error().message(), HasSubstr("catan run --record FILE"));
}

TEST(Reader, RefusesWhatIsNoRecord) {
  const Folder folder;
  write_bytes(folder.file("text"), std::string(5000, 'x'));
  write_bytes(folder.file("empty"), "");
  std::filesystem::create_directory(folder.file("folder"));
  ASSERT_TRUE(sqlite::Database::open(folder.file("other"), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE)
                  ->execute("CREATE TABLE meta(key, value)")
                  .ok());
  for (const char* name : {"text", "empty", "other", "folder"}) {
    const auto reader = Reader::open(folder.file(name));
    ASSERT_FALSE(reader.ok()) << name;
    EXPECT_EQ(reader.error().kind(), ErrorKind::kCaller) << name;
  }
}

TEST(Reader, RefusesANewerVersion) {
  EXPECT_THAT(error_after("PRAGMA user_version = 2"), HasSubstr("newer version of Catan"));
}

TEST(Reader, RefusesAnotherSchema) {
  EXPECT_THAT(error_after("DROP TABLE triggers"), HasSubstr("no table 'triggers'"));
  EXPECT_THAT(error_after("ALTER TABLE runs RENAME COLUMN cpu_ns TO cpu"), HasSubstr("no column 'cpu_ns'"));
  EXPECT_THAT(error_after("ALTER TABLE runs RENAME TO r; CREATE VIEW runs AS SELECT * FROM r"),
              HasSubstr("no table 'runs'"));
  EXPECT_THAT(error_after("DROP TABLE plans; CREATE VIRTUAL TABLE plans USING fts5(id, at_ns, reason, json)"),
              HasSubstr("no table 'plans'"));
}

TEST(Reader, LeavesAlonePartsThatAreNotItsOwn) {
  EXPECT_EQ(
      error_after("ALTER TABLE runs ADD COLUMN remark; CREATE TABLE mine(x); CREATE VIEW v AS SELECT * FROM runs; "
                  "CREATE INDEX i ON runs(end_ns); INSERT INTO meta VALUES ('mine', x'00')"),
      "");
}

TEST(Reader, ReadsRecordsFromBeforeWaitsOrCpusWereKept) {
  EXPECT_EQ(error_after("ALTER TABLE runs DROP COLUMN wait_ns"), "");
  EXPECT_EQ(error_after("ALTER TABLE runs DROP COLUMN on_cpu"), "");
}

TEST(Reader, ReadsRecordsFromBeforeItWasKeptWhoNeedsInput) {
  EXPECT_EQ(error_after("ALTER TABLE nodes DROP COLUMN needs_input"), "");
}

TEST(Reader, RefusesValuesThatNoWriterWrites) {
  for (const char* sql : {
           "UPDATE runs SET node = 99 WHERE number = 1 AND node = 1",
           "UPDATE runs SET node = -1 WHERE number = 1 AND node = 1",
           "UPDATE runs SET node = 'x' WHERE number = 1 AND node = 1",
           "UPDATE runs SET node = 1.5 WHERE number = 1 AND node = 1",
           "UPDATE runs SET begin_ns = end_ns + 1",
           "UPDATE runs SET end_ns = 9223372036854775807",
           "UPDATE runs SET end_ns = 1e300",
           "UPDATE runs SET cpu_ns = -1",
           "UPDATE runs SET wait_ns = -1",
           "UPDATE runs SET on_cpu = -1",
           "UPDATE runs SET on_cpu = 'a'",
           "UPDATE runs SET mode = 4294967296",
           "UPDATE runs SET emitted = 'yes'",
           "UPDATE runs SET number = -number",
           "UPDATE consumed SET first = 5, last = 4",
           "UPDATE consumed SET predecessor = 77",
           "UPDATE consumed SET first = 0",
           "UPDATE consumed SET run = 'x' WHERE run = 1",
           "UPDATE triggers SET subchain = 9",
           "UPDATE triggers SET due_ns = x'00'",
           "UPDATE plans SET json = x'00ff'",
           "UPDATE notices SET kind = 5, detail = x'00'",
           "UPDATE nodes SET id = 1000 WHERE id = 0",
           "UPDATE nodes SET input = 'stack'",
           "UPDATE nodes SET name = '' WHERE id = 0",
           "UPDATE nodes SET max_rate_hz = 9e999 WHERE id = 1",
           "UPDATE nodes SET max_rate_hz = -1 WHERE id = 1",
           "UPDATE nodes SET max_threads = 0",
           "UPDATE nodes SET needs_input = 2",
           "DELETE FROM nodes",
           "UPDATE edges SET to_node = from_node",
           "UPDATE edges SET to_node = 99",
           "UPDATE age_limits SET edge = edge + 99",
           "UPDATE age_limits SET max_age_ns = 0",
           "UPDATE age_limits SET max_age_ns = -1",
           "UPDATE age_limits SET max_age_ns = 'long'",
           "UPDATE age_limits SET on_stale = 'stop'",
           "DELETE FROM subchain_nodes",
           "UPDATE subchain_nodes SET position = position + 7",
           "UPDATE chains SET metric = 'speed'",
           "UPDATE chains SET weight = -1",
           "DELETE FROM chain_nodes",
           "INSERT INTO app_changes VALUES (1, 5, 'weight', 99, 0.5, 1.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'weight', 0, 0.5, NULL)",
           "INSERT INTO app_changes VALUES (1, 5, 'weight', 0, 0.5, -1.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'weight', 0, 0.5, 'much')",
           "INSERT INTO app_changes VALUES (1, -5, 'weight', 0, 0.5, 1.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'order', 0, 0.5, 1.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'max', 1, NULL, 5.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'min_rate', 0, NULL, 5.0)",
           "INSERT INTO app_changes VALUES (1, 5, 'min_rate', 1, NULL, 9e999)",
           "DELETE FROM meta",
           "DELETE FROM meta WHERE key = 'started_ns'",
           "UPDATE meta SET value = -5 WHERE key = 'warm_up_ns'",
           "UPDATE meta SET value = 5 WHERE key = 'ended_ns'",
           "UPDATE meta SET value = 'x' WHERE key = 'cpus'",
           "UPDATE meta SET value = 0 WHERE key = 'option_window'",
           "UPDATE meta SET value = 101.0 WHERE key = 'option_percentile'",
       }) {
    EXPECT_NE(error_after(sql), "") << sql;
  }
}

TEST(Reader, ATruncatedRecordIsAnError) {
  const Folder folder;
  const std::string bytes = read_bytes(sample_record(folder));
  int whole = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 509) {
    write_bytes(folder.file("cut"), bytes.substr(0, size));
    const Status status = read_all(folder.file("cut"));
    if (status) {
      ++whole;
      continue;
    }
    EXPECT_EQ(status.error().kind(), ErrorKind::kCaller) << size << ": " << status.error().message();
  }
  EXPECT_EQ(whole, 0);
}

// Damaged anywhere: an error or some reading, but never a crash (run under the sanitizers, this is the point of it).
TEST(Reader, ReadsRecordsOfBeforeThereWereSlotsAndAgeLimits) {
  const Folder folder;
  const std::string path = sample_record(folder);
  {
    auto database = sqlite::Database::open(path, SQLITE_OPEN_READWRITE);
    ASSERT_TRUE(database
                    ->execute("DROP TABLE slots; DROP TABLE steals; DROP TABLE core_kinds; DROP TABLE exclusive; DROP "
                              "TABLE age_limits")
                    .ok());
  }
  const auto reader = Reader::open(path);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  EXPECT_TRUE(reader->app().core_kinds.empty());
  for (const graph::Edge& edge : reader->app().graph.edges()) EXPECT_FALSE(edge.age_limit);
  const Status done = read_all(path);
  EXPECT_TRUE(done.ok()) << done.error().message();
}

RC_GTEST_PROP(ReaderProperty, SurvivesDamage, ()) {
  static const Folder kFolder;
  static const std::string kBytes = read_bytes(sample_record(kFolder));
  std::string bytes = kBytes;
  for (int i = *rc::gen::inRange(1, 20); i > 0; --i) {
    bytes[*rc::gen::inRange<std::size_t>(0, bytes.size())] = static_cast<char>(*rc::gen::inRange(0, 256));
  }
  write_bytes(kFolder.file("damaged"), bytes);
  const Status status = read_all(kFolder.file("damaged"));
  if (!status) RC_ASSERT(!status.error().message().empty());
}

TEST(RecordSchemaPage, ItsQueriesRunAndNameEveryColumn) {
  const Folder folder;
  const std::string page = read_bytes(CATAN_DOCS "/record-schema.md");
  auto database = sqlite::Database::open(sample_record(folder), SQLITE_OPEN_READONLY);
  ASSERT_TRUE(database.ok());
  int queries = 0;
  const std::string fence = "```sql\n";
  for (std::size_t begin = page.find(fence); begin != std::string::npos; begin = page.find(fence, begin)) {
    begin += fence.size();
    const std::string sql = page.substr(begin, page.find("```", begin) - begin);
    auto rows = database->prepare(sql);
    ASSERT_TRUE(rows.ok()) << sql << ": " << rows.error().message();
    const auto row = rows->next();
    EXPECT_TRUE(row.ok() && *row) << "no result: " << sql;
    ++queries;
  }
  EXPECT_EQ(queries, 3);

  auto columns = database->prepare(
      "SELECT s.name, c.name FROM sqlite_schema AS s, pragma_table_info(s.name) AS c WHERE s.type = 'table'");
  ASSERT_TRUE(columns.ok());
  while (*columns->next()) {
    const std::size_t table = page.find("**" + columns->text(0) + "**(");
    ASSERT_NE(table, std::string::npos) << columns->text(0);
    EXPECT_LT(page.find("`" + columns->text(1) + "`", table), page.find(')', table))
        << columns->text(0) << "." << columns->text(1);
  }
  auto keys = database->prepare("SELECT key FROM meta");
  while (*keys->next()) EXPECT_THAT(page, HasSubstr("`" + keys->text(0) + "`"));
}

}  // namespace
}  // namespace ctn::record
