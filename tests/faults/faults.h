// The faults that a served app must survive, each injected many times into a pipeline (pipeline.h) that runs on in
// between. bench/faults_bench.cpp makes a table of them, tests/faults_test.cpp judges a few of each.
//
// Units: milliseconds of samples. Thread safety: one thread, in a process without others.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline.h"

namespace ctn::faults {

// From the fault to ...
struct Recovery {
  std::string until;
  std::vector<double> ms;
  bool all = true;  // false: it did not always come to that, which is no condition of survival
};

struct FaultReport {
  std::string fault;
  int injected = 0;
  int survived = 0;
  std::vector<Recovery> recoveries;
  // How often the other nodes ran while the fault lasted, over how often they would have without; none: not asked.
  std::optional<double> others;
  int records = 0;        // that servers left
  int records_whole = 0;  // readable, closed where the server was, and without a gap that the fault does not explain
  double unwritten_ms = 0.0;          // the most that a killed server's record ended before the kill
  int raised_left = 0;                // threads above the ordinary level after the last server's end
  std::uint64_t steals = 0;           // of the subchain `fast`, since the first fault
  TimePoint begin{};                  // of the first fault
  int files_left = 0;                 // descriptors that servers and programs had more at the end than at the beginning
  double observer_late_ms = 0.0;      // the most that we ourselves woke late, at a real-time level
  std::vector<std::string> failures;  // the first few, for people
};

struct Fault;
const std::vector<Fault>& all_faults();

// Where programs are: `catan` and fault_player. `go_on` is asked before each injection.
struct Place {
  std::string command;
  std::string player;
  std::function<bool()> go_on = [] { return true; };
};
FaultReport inject(const Fault& fault, int times, const Place& place);

// What one injection does and finds.
class Injection {
 public:
  Injection(Pipeline& pipeline, int number, FaultReport& report) : p(pipeline), round(number), report_(report) {}

  // A condition of survival: why it is not met is told.
  bool must(bool holds, const std::string& what);
  // Waits for it, which is a condition of survival, and takes down how long that was.
  bool recovers(std::size_t recovery, const std::function<bool()>& holds, TimePoint since);
  // The same, but it need not.
  void may_recover(std::size_t recovery, const std::function<bool()>& holds, TimePoint since);
  // From watch() on others run at `others_min` of their rate at least, for so long.
  void watch();
  void others_run(const std::vector<std::size_t>& others, Nanos meanwhile);
  // That of the server that has just ended, in order or killed.
  void judge_record(bool in_order, TimePoint killed);
  bool survived() const { return survived_; }

  Pipeline& p;
  int round;

 private:
  friend FaultReport inject(const Fault& fault, int times, const Place& place);
  FaultReport& report_;
  bool survived_ = true;
  Nanos timeout_{};
  double min_ = 0.0;
  std::array<std::uint64_t, kNodes.size()> runs_then_{};  // at watch()
  TimePoint then_{};
  std::uint64_t gaps_ = 0;                     // runs that may be missing in the record
  std::array<double, kNodes.size()> usual_{};  // runs a second
  double runs_ = 0.0;
  double expected_ = 0.0;
};

struct Fault {
  std::string name;
  std::vector<std::string> recoveries;
  std::function<void(Injection&)> inject;
  int at_once = 1;                           // faults in one injection
  bool with_server = true;                   // the server lives through it: rates of others are compared
  bool untrue = false;                       // what is reported meanwhile need not be true, so records may have gaps
  int gaps = 0;                              // runs that an injection breaks off
  bool in_frames = false;                    // planned so, and each fault makes `fast` steal, as none does elsewhere
  Nanos timeout = std::chrono::seconds{20};  // for each recovery
  double others_min = 0.5;                   // of the rate that others had before
  Nanos by_design{0};                        // what a recovery takes at least: a run counts as hanging after a second
  std::vector<std::size_t> absent{};         // nodes that no program of ours plays
};

}  // namespace ctn::faults
