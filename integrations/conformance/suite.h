// The suite's fixture: a server (the real command), programs in processes of their own, and what they count in memory
// that they share with the test.
//
// A port adds one file with
//   INSTANTIATE_TEST_SUITE_P(Sample, PortSuite, testing::Values(PortUnderTest{"sample", make_port}), name_of);
// Thread safety: one thread, and it must be the only one of the process: programs are forked.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "conformance/port.h"

namespace ctn::conformance {

// Of one node.
struct Counters {
  std::atomic<std::int64_t> begun{0};
  std::atomic<std::int64_t> ended{0};
  std::atomic<std::int64_t> published{0};
  std::atomic<std::int64_t> received{0};
  std::atomic<std::int64_t> newest{0};    // message
  std::atomic<std::int64_t> gaps{0};      // messages whose predecessor was not the one before
  std::atomic<std::int64_t> backward{0};  // messages that were not newer
  // Messages that the next node had not taken when another was published: at rates that are set by hand no trigger
  // waits for the run before, and a thread of a busy machine may begin a period late.
  std::atomic<std::int64_t> overtaken{0};
};

class PortSuite : public testing::TestWithParam<PortUnderTest> {
 protected:
  PortSuite();
  ~PortSuite() override;

  // `catan serve` of an app, for `scheduler` as the command takes it. Again: another server at the same socket.
  void serve(const std::string& app, const std::string& scheduler);
  void kill_server();
  // Ends it in order, and reports what it recorded.
  nlohmann::json report();

  using Program = int;  // a process
  Program start(const std::vector<Node>& nodes);
  void kill_program(Program program);
  // Asks it to end; its exit code, or 128 + the signal that killed it.
  int stop(Program program);

  Counters& of(std::size_t node) { return (*counters_)[node]; }
  // A node that counts what it does in of(index), and does `work`, if given.
  Node counting(std::size_t index, const std::string& name, const std::vector<Node::Input>& inputs = {},
                const std::function<void(Call&)>& work = {});
  // Publishes the next message of a node, which a node `taker` takes, and counts in of(index) if that one is late.
  void publish_next(Call& call, std::size_t index, std::size_t taker);
  // Until the node was called so often more.
  bool called(std::size_t node, std::int64_t more, std::chrono::milliseconds within = std::chrono::seconds{10});

  static nlohmann::json node(const nlohmann::json& report, const std::string& name);
  static void burn(std::chrono::microseconds cpu_time);

 private:
  std::string folder_;
  std::string app_file_;
  int records_ = 0;
  int server_ = 0;
  std::vector<Program> programs_;
  std::array<Counters, 8>* counters_;
};

inline void PrintTo(const PortUnderTest& port, std::ostream* out) { *out << port.name; }  // NOLINT: GoogleTest's name
inline std::string name_of(const testing::TestParamInfo<PortUnderTest>& info) { return info.param.name; }

}  // namespace ctn::conformance
