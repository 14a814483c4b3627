// A record's tables as CSV, parsed back.
#include "export/csv.h"

#include <gmock/gmock.h>

#include "export/testing/samples.h"

namespace ctn::exports {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

using Row = std::vector<std::string>;

// Parses as RFC 4180 says.
std::vector<Row> parsed(const std::string& text) {
  std::vector<Row> rows;
  Row row;
  std::string field;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      const bool doubled = c == '"' && i + 1 < text.size() && text[i + 1] == '"';
      if (c != '"' || doubled) field += c;
      if (doubled) ++i;
      quoted = c != '"' || doubled;
    } else if (c == '"') {
      EXPECT_THAT(field, IsEmpty()) << "a quote in the middle of a field";
      quoted = true;
    } else if (c == ',' || c == '\n') {
      row.push_back(std::exchange(field, {}));
      if (c == '\n') rows.push_back(std::exchange(row, {}));
    } else {
      field += c;
    }
  }
  EXPECT_THAT(field, IsEmpty()) << "no newline at the end";
  return rows;
}

class CsvTest : public testing::Test {
 protected:
  template <class Add>
  std::string record_of(Add add, bool complete = true) {
    std::string path = folder_.file("r");
    const auto writer = make(path, app_);
    add(*writer, app_);
    EXPECT_TRUE((complete ? writer->close(at(seconds{110}), header().host) : writer->flush()).ok());
    return path;
  }
  static std::vector<Row> table(const std::string& record, std::string_view name) {
    std::string text;
    const Status done = write_csv(open(record), name, into(text), [](double part) { EXPECT_LE(part, 1.0); });
    EXPECT_TRUE(done.ok()) << name << ": " << (done ? "" : done.error().message());
    return parsed(text);
  }

  Folder folder_;
  graph::App app_ = robot();
};

TEST_F(CsvTest, TablesHaveNamesAndUnits) {
  const std::string record = record_of(add_sample);
  const std::vector<Row> runs = table(record, "runs");
  ASSERT_THAT(runs, SizeIs(8));
  EXPECT_THAT(runs[0],
              ElementsAre("node", "run", "begin_s", "end_s", "cpu_ms", "wait_ms", "mode", "emitted", "on_cpu"));
  EXPECT_THAT(runs[1], ElementsAre("scan", "1", "3.000000000", "3.001000000", "0.900000", "0.000000", "", "1", ""));
  EXPECT_THAT(runs[7], ElementsAre("GL", "1", "3.030000000", "3.039000000", "8.000000", "0.700000", "match", "0", "3"));
  EXPECT_THAT(table(record, "consumed")[5], ElementsAre("GL", "1", "scan", "1", "2"));
  EXPECT_THAT(table(record, "triggers")[2], ElementsAre("local", "2", "3.020000000", "3.020250000", "0.250000"));
  EXPECT_THAT(table(record, "slots")[1], ElementsAre("1", "GL", "3.029000000", "3.030000000", "3.040000000"));
  EXPECT_THAT(table(record, "steals")[1], ElementsAre("1", "local", "GL", "3.028000000", "3.030000000"));
  EXPECT_THAT(table(record, "overruns")[1], ElementsAre("local", "2", "3.023000000", "2.500000"));
  EXPECT_THAT(table(record, "plans")[2], ElementsAre("2", "2.000000000", "measured", "auto", "100", "1", "percentile"));
  EXPECT_THAT(table(record, "cost_changes")[1],
              ElementsAre("4.000000000", "GL", "match", "little", "4.000000", "8.000000", "6"));
  EXPECT_THAT(table(record, "app_changes")[1][0], "5.000000000");
  EXPECT_THAT(table(record, "notices")[1], ElementsAre("6.000000000", "watchdog", kHostile));
}

TEST_F(CsvTest, ResponsesStandBesideWhatWasPromised) {
  const std::vector<Row> responses = table(record_of(add_sample), "responses");
  ASSERT_THAT(responses, SizeIs(3));
  const std::string chain = "scan -> LM -> LP -> base";
  EXPECT_THAT(responses[1],
              ElementsAre(chain, "1", "3.000000000", "3.004000000", "4.000000", "", "", "30", "30", "60"));
  EXPECT_THAT(responses[2],
              ElementsAre(chain, "2", "3.020000000", "3.024000000", "4.000000", "20", "24", "30", "30", "60"));
}

TEST_F(CsvTest, TablesOfAnEmptyRecordHaveTheirColumns) {
  const std::string record = record_of([](record::Writer&, const graph::App&) {});
  for (const std::string_view name : csv_tables()) EXPECT_THAT(table(record, name), SizeIs(1)) << name;
}

TEST_F(CsvTest, AllLinesOfATableHaveItsColumns) {
  for (const bool complete : {true, false}) {
    const std::string record = record_of(complete ? add_sample : add_nonsense, complete);
    for (const std::string_view name : csv_tables()) {
      const std::vector<Row> rows = table(record, name);
      for (const Row& row : rows) EXPECT_THAT(row, SizeIs(rows[0].size())) << name;
    }
    std::filesystem::remove(record);
  }
}

TEST_F(CsvTest, TimesBeforeTheStartAreNegative) {
  const std::string record = record_of(add_nonsense);
  EXPECT_EQ(table(record, "notices")[1][0], "-99.000000000");
  EXPECT_EQ(table(record, "triggers")[1][4], "-1.000000");
}

TEST_F(CsvTest, TheFirstFailureOfTheSinkIsTold) {
  const std::string record = record_of(add_sample);
  const Sink full = [](std::string_view) -> Status { return Error::environment("the disk is full", "make room"); };
  for (const std::string_view name : csv_tables()) {
    EXPECT_FALSE(write_csv(open(record), name, full, [](double) {}).ok()) << name;
  }
}

}  // namespace
}  // namespace ctn::exports
