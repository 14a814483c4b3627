// The rules find what they are for: each is shown a file that breaks it, and one beside it that does not.
#include "architecture/source_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ctn::architecture {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

ModuleTable table() {
  return parse_module_table("\nbase:\nplan:base\nos:base\nruntime:base os plan\napi:base runtime\n");
}

std::vector<std::string> check(const std::string& path, const std::string& text) {
  const std::string guard = path.ends_with(".h") ? "#pragma once\n" : "\n";
  return check_source({path, guard + text}, table());
}

TEST(ModuleTable, IsReadAsTheBuildWritesIt) {
  EXPECT_EQ(table().at("base"), std::set<std::string>{});
  EXPECT_EQ(table().at("runtime"), (std::set<std::string>{"base", "os", "plan"}));
  EXPECT_EQ(table().size(), 5U);
}

TEST(SourceRules, AModuleIncludesOnlyWhatItsRowAllows) {
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"base/time.h\"\n#include \"plan/plan.h\"\n#include <vector>"),
              IsEmpty());
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"base/time.h\"\n#include \"os/os.h\""),
              ElementsAre("src/plan/a.cpp:3: plan may not include os"));
  EXPECT_THAT(check("src/plan/a.cpp", "#include <os/os.h>"),
              ElementsAre("src/plan/a.cpp:2: a module's header is included with quotes"));
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"../os/os.h\""),
              ElementsAre("src/plan/a.cpp:2: \"../os/os.h\" does not start with the name of a module"));
  EXPECT_THAT(check("src/other/a.cpp", ""), ElementsAre("src/other/a.cpp:1: src/other is no module of the build"));
}

TEST(SourceRules, TestsMayUseTheFakeSystem) {
  const std::string text = "#include \"os/fake/fake_cpus.h\"";
  EXPECT_THAT(check("src/plan/a_test.cpp", text), IsEmpty());
  EXPECT_THAT(check("src/plan/testing/a.h", text), IsEmpty());
  EXPECT_THAT(check("src/plan/a.cpp", text), ElementsAre("src/plan/a.cpp:2: plan may not include os"));
  EXPECT_THAT(check("src/plan/a_test.cpp", "#include \"os/os.h\""),
              ElementsAre("src/plan/a_test.cpp:2: plan may not include os"));
}

TEST(SourceRules, PublicHeadersBelongToTheApiSaveForThoseThatNeedNoLibrary) {
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"catan/result.h\""), IsEmpty());
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"catan/channel.h\"\n#include \"catan/run.h\""), IsEmpty());
  EXPECT_THAT(check("src/runtime/a.cpp", "#include \"catan/snapshot.h\""), IsEmpty());
  EXPECT_THAT(check("src/api/a.cpp", "#include \"catan/session.h\""), IsEmpty());
  EXPECT_THAT(check("src/plan/a.cpp", "#include \"catan/session.h\""),
              ElementsAre("src/plan/a.cpp:2: plan may not include api"));
}

TEST(SourceRules, PublicHeadersNeedOnlyTheStandardLibrary) {
  EXPECT_THAT(check("include/catan/a.h", "#include <vector>\n#include \"catan/run.h\""), IsEmpty());
  EXPECT_THAT(check("include/catan/a.h", "#include <fmt/format.h>\n#include \"base/time.h\"\n#include <sched.h>"),
              ElementsAre("include/catan/a.h:2: a public header may not include fmt/format.h",
                          "include/catan/a.h:3: a public header may not include base/time.h",
                          "include/catan/a.h:4: a public header may not include sched.h",
                          "include/catan/a.h:4: only os/linux may include <sched.h>"));
}

TEST(SourceRules, AppsUseOnlyThePublicApi) {
  EXPECT_THAT(check("apps/x/a.cpp", "#include \"catan/session.h\"\n#include \"world.h\""), IsEmpty());
  EXPECT_THAT(check("apps/x/a.cpp", "#include \"plan/plan.h\""),
              ElementsAre("apps/x/a.cpp:2: apps use only the public API, not plan/plan.h"));
}

TEST(SourceRules, OnlyOsLinuxIncludesSystemHeaders) {
  const std::string text = "#include <sched.h>\n#include <pthread.h>\n#include <sys/mman.h>\n#include <linux/futex.h>";
  EXPECT_THAT(check("src/os/linux/a.cpp", text), IsEmpty());
  EXPECT_EQ(check("src/os/fake/a.cpp", text).size(), 4U);
  EXPECT_EQ(check("src/runtime/a.cpp", text).size(), 4U);
  EXPECT_EQ(check("tools/catan/a.cpp", text).size(), 4U);
  EXPECT_THAT(check("src/runtime/a.cpp", "#include <unistd.h>"), IsEmpty());
}

TEST(SourceRules, OnlyOsNamesSchedulingClasses) {
  EXPECT_THAT(check("src/os/linux/a.cpp", "int policy = SCHED_FIFO;"), IsEmpty());
  EXPECT_THAT(check("src/runtime/a.cpp", "// maps to SCHED_FIFO\n"), IsEmpty());
  EXPECT_EQ(check("src/runtime/a.cpp", "int policy = SCHED_FIFO;").size(), 1U);
  EXPECT_EQ(check("src/runtime/a.cpp", "say(\"SCHED_RR was refused\");").size(), 1U);
  EXPECT_EQ(check("apps/x/a.cpp", "int policy = SCHED_DEADLINE;").size(), 1U);
}

TEST(SourceRules, OnlyOsReadsAClock) {
  const std::vector<std::string> reads = {"std::chrono::steady_clock::now()", "std::chrono::system_clock::now()",
                                          "high_resolution_clock::now()",     "clock_gettime(CLOCK_MONOTONIC, &t)",
                                          "gettimeofday(&t, nullptr)",        "std::time(nullptr)"};
  for (const std::string& read : reads) {
    EXPECT_EQ(check("src/plan/a.cpp", "auto t = " + read + ";").size(), 1U) << read;
    EXPECT_THAT(check("src/os/linux/a.cpp", "auto t = " + read + ";"), IsEmpty()) << read;
    EXPECT_THAT(check("apps/x/a.cpp", "auto t = " + read + ";"), IsEmpty()) << read;
    EXPECT_THAT(check("src/plan/a.cpp", "// " + read + "\n/* " + read + " */"), IsEmpty()) << read;
    EXPECT_THAT(check("src/plan/a.cpp", "say(\"" + read + "\");"), IsEmpty()) << read;
  }
  EXPECT_THAT(check("src/plan/a.cpp", "auto t = run_time(0); auto u = cells.time(0) + cells->time(0) + os.now();"),
              IsEmpty());
}

TEST(SourceRules, WhatFollowsALiteralOrAnApostropheIsSeen) {
  const std::string read = "auto t = steady_clock::now();";
  EXPECT_EQ(check("src/plan/a.cpp", "char c = '\"'; " + read).size(), 1U);
  EXPECT_EQ(check("src/plan/a.cpp", "const char* s = \"\\\"//\"; " + read).size(), 1U);
  EXPECT_EQ(check("src/plan/a.cpp", "const char* s = R\"x(\" /* )x\"; " + read).size(), 1U);
  EXPECT_EQ(check("src/plan/a.cpp", "int n = 1'000'000; " + read).size(), 1U);
}

TEST(SourceRules, WhoWaitsKnowsWhatItSawLast) {
  EXPECT_THAT(check("src/runtime/a.cpp", "while (word.load() < 3) os_.wait(word, word.load(), kNever);\n"),
              ElementsAre("src/runtime/a.cpp:2: wait for a change of the value that was looked at, not of the newest"));
  EXPECT_THAT(check("src/runtime/a.cpp", "os_.wait(word, seen, kNever);\nos_.wait(word, other.load(), kNever);\n"),
              IsEmpty());
}

TEST(SourceRules, HeadersHavePragmaOnce) {
  EXPECT_THAT(check_source({"src/plan/a.h", "#pragma once\n"}, table()), IsEmpty());
  EXPECT_THAT(check_source({"src/plan/a.h", "#ifndef A_H\n#define A_H\n#endif\n"}, table()),
              ElementsAre("src/plan/a.h:1: a header has #pragma once"));
  EXPECT_THAT(check_source({"src/plan/a.h", "// #pragma once\n"}, table()), testing::SizeIs(1));
}

TEST(TextRules, FindWhatDoesNotBelongInAText) {
  EXPECT_THAT(check_text({"a", "gr\xC3\xBC\xC3\x9F dich \xF0\x9F\x98\x80\n"}, false), IsEmpty());
  EXPECT_THAT(check_text({"a", "a\tb\nc \nd\r\ne"}, false),
              ElementsAre("a:1: a tab", "a:2: blanks at the end of the line", "a:3: blanks at the end of the line",
                          "a:4: no newline at the end of the file"));
  EXPECT_THAT(check_text({"Makefile", "a:\n\tb\n"}, true), IsEmpty());
  for (const char* bad : {"\xFF\n", "\xC3\n", "\xC0\xAF\n", "\xE0\x80\x80\n", "\xED\xA0\x80\n", "\xF4\x90\x80\x80\n"}) {
    EXPECT_THAT(check_text({"a", bad}, false), ElementsAre("a:1: not UTF-8")) << testing::PrintToString(bad);
  }
}

TEST(MarkdownLinks, AreThoseWithinTheRepository) {
  const std::vector<Link> links = relative_links(
      "[a](docs/a.md) and [b](b.md#part)\n"
      "[web](https://example.org) [here](#part) `[code](no.md)` <!-- [comment](no.md) -->\n"
      "```\n[code](no.md)\n```\n"
      "![p](p.svg) <img src=\"q.svg\" width=\"9\">\n");
  std::vector<std::string> found;
  found.reserve(links.size());
  for (const Link& link : links) found.push_back(std::to_string(link.line) + " " + link.target + "#" + link.section);
  EXPECT_THAT(found, ElementsAre("1 docs/a.md#", "1 b.md#part", "2 #part", "6 p.svg#", "6 q.svg#"));
}

TEST(MarkdownSections, AreItsHeadingsAndElementsWithAnId) {
  EXPECT_THAT(sections_of("# One, two\n```\n# code\n```\n### 3. By [`a_b`](c.md): yes\n<a id=\"old\"></a> # none\n"),
              ElementsAre("3-by-a_b-yes", "old", "one-two"));
}

}  // namespace
}  // namespace ctn::architecture
