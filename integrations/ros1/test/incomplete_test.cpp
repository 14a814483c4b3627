// Programs of a subchain of which one is missing or was killed: the others are as without Catan until it comes. A real
// roscore, processes of their own, the real command. Times are generous: it is the real machine, and it may be busy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

class IncompleteTest : public ProgramsTest {
 protected:
  // A subchain of `first` and `last`, with these keys and bindings of the first; the last takes /things.
  void serve(const std::string& keys, const std::string& binding) {
    write("app.yaml", "catan: 1\napp: two\nnodes: { first: { " + keys + R"( }, last: {} }
edges: [ first -> last ]
subchains: { pair: [first, last] }
objective: [ { response_time: [first, last], weight: 1 } ]
scheduler: { bootstrap: 300ms }
)");
    write("bind.yaml",
          "catan: 1\nros:\n  first: { node: /first, " + binding + " }\n  last: { node: /last, topic: /things }\n");
    start("serve", std::string(CATAN_COMMAND) + " serve app.yaml --scheduler default --socket server");
  }
  int join(const std::string& node, const std::string& arguments) {
    return start(node, std::string(CATAN_COMMAND) + " ros run app.yaml --bind bind.yaml --socket server -- " +
                           PLAIN_NODE + " " + node + " " + arguments + " --counts " + node + ".json");
  }
  void kill(int process) {
    ::kill(process, SIGKILL);
    wait(process, seconds{5});
  }
  // In memory.
  static long megabytes_of(int process) {
    std::ifstream pages("/proc/" + std::to_string(process) + "/statm");
    long size = 0;
    long resident = 0;
    pages >> size >> resident;
    return resident * ::sysconf(_SC_PAGESIZE) / (1024 * 1024);
  }
  // So often the node's callback is called in a second, once that is so or 20 s have passed.
  long calls_in_a_second(const std::string& node, const std::function<bool(long)>& is_so) const {
    long calls = 0;
    for (int tries = 0; tries < 20; ++tries) {
      const long before = counted(node, "calls");
      std::this_thread::sleep_for(seconds{1});
      calls = counted(node, "calls") - before;
      if (is_so(calls)) break;
    }
    return calls;
  }
  // The timer of 20 ms calls, or a trigger does, 5 times a second.
  long calls_of_timer(const std::string& node) const {
    return calls_in_a_second(node, [](long calls) { return calls > 30; });
  }
  long calls_of_triggers(const std::string& node) const {
    return calls_in_a_second(node, [](long calls) { return calls < 15; });
  }
};

TEST_F(IncompleteTest, WhereAProgramIsMissingOrKilledTheOtherIsAsWithoutCatan) {
  serve("fallback_rate: 5Hz", "timer: 20ms");
  start_node("reader", "--in /things");
  join("first", "--timer 20 --sleep 15 --threads 3 --out /things");
  EXPECT_GT(calls_of_timer("first"), 30) << text_of(path("first.err"));
  EXPECT_TRUE(counts("reader", "calls", 20)) << "who is no part of the app";
  int last = 0;
  for (int round = 0; round < 2; ++round) {
    SCOPED_TRACE(round);
    last = join("last", "--in /things");
    ASSERT_TRUE(counts("last", "calls", 5)) << text_of(path("last.err"));
    EXPECT_LT(calls_of_triggers("first"), 15) << "triggered again";
    EXPECT_TRUE(counts("last", "calls", 5));
    kill(last);
    EXPECT_GT(calls_of_timer("first"), 30);
    EXPECT_TRUE(counts("reader", "calls", 20));
  }
  EXPECT_EQ(counted("first", "overlaps"), 0) << "a timer's callback is called by one thread at a time";
  const std::string told = text_of(path("serve.err")) + text_of(path("serve.out"));
  EXPECT_THAT(told, HasSubstr("subchain pair is let go of until node last is there"));
  EXPECT_THAT(told, HasSubstr("subchain pair runs: all of its nodes have registered"));
}

TEST_F(IncompleteTest, EachMessageIsHandledOnceWhoeverCalls) {
  serve("fallback_rate: 10Hz, input: queue", "topic: /data");
  join("first", "--in /data --burn 1 --threads 3 --queue 1000 --out /things --log first.log");
  start_node("feed", "--timer 10 --out /data");
  ASSERT_TRUE(counts("first", "calls", 50)) << text_of(path("first.err"));
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const int last = join("last", "--in /things");
    EXPECT_TRUE(counts("last", "calls", 10)) << text_of(path("last.err"));
    EXPECT_TRUE(counts("first", "calls", 100));
    kill(last);
    EXPECT_TRUE(counts("first", "calls", 300)) << "also by the program's spinner";
  }
  EXPECT_EQ(counted("first", "overlaps"), 0);
  std::istringstream log(text_of(path("first.log")));
  const std::vector<long> got(std::istream_iterator<long>(log), {});
  ASSERT_GT(got.size(), 1000U);
  EXPECT_EQ(std::adjacent_find(got.begin(), got.end(), std::greater_equal<>{}), got.end()) << "none twice, in order";
  // The feed keeps ten for a receiver that is late.
  EXPECT_GE(static_cast<long>(got.size()), (got.back() - got.front() + 1) * 99 / 100);
}

TEST_F(IncompleteTest, AServiceIsAnsweredWhileAProgramIsMissing) {
  serve("fallback_rate: 5Hz", "service: /question");
  join("first", "--service /question --out /things");
  start_node("client", "--timer 20 --ask /question");
  EXPECT_GT(calls_of_timer("first"), 30) << text_of(path("first.err"));
  join("last", "--in /things");
  ASSERT_TRUE(counts("last", "calls", 5)) << text_of(path("last.err"));
  EXPECT_LT(calls_of_triggers("first"), 15) << "who asks waits for the trigger again";
  EXPECT_EQ(counted("first", "overlaps"), 0);
}

// Guards: with a long queue of the program's, a node that waited for its trigger took a gigabyte.
TEST_F(IncompleteTest, MessagesDoNotPileUpWhileNoTriggerComes) {
  write_app_of_work("fallback_rate: 0.05Hz");
  write_binding_of_work("/worker");
  start("serve", std::string(CATAN_COMMAND) + " serve app.yaml --scheduler default --socket server");
  start_node("feed", "--timer 20 --strings 400 --out /data");
  const int worker = join("worker", "--in /data --queue 1000 --strings 400 --beside /ticks");
  start_node("ticks", "--timer 20 --out /ticks");
  ASSERT_TRUE(counts("worker", "beside", 10)) << text_of(path("worker.err"));
  const long before = megabytes_of(worker);
  const long fed = counted("feed", "calls");
  ASSERT_TRUE(counts("feed", "calls", 250));
  EXPECT_LT(megabytes_of(worker) - before, 30) << "of some 100 that have come";
  EXPECT_LT(counted("worker", "calls"), 5);
  EXPECT_GE(counted("feed", "calls") - fed, 250);
}

}  // namespace
}  // namespace catan_ros
