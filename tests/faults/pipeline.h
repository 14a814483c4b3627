// A served app to be tormented: the real `catan serve` on one CPU, and for each of five nodes a real program
// (player.cpp). What happens is seen from outside: what threads' scheduling is, what the server says, what the programs
// write into memory that they share with us, and what is in the records.
//
// Failures of the set-up (a program that cannot be started) are thrown. Thread safety: one thread; the process has no
// other when it makes one, since it forks.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/time.h"
#include "os/linux/child_process.h"
#include "os/os.h"
#include "state.h"

namespace ctn::faults {

// What a record holds.
struct RecordFacts {
  bool readable = false;
  bool complete = false;     // the server closed it
  std::uint64_t runs = 0;    // all nodes
  std::uint64_t steals = 0;  // of the first subchain, since the time that was asked for
  // By node: numbers that are not there, between its first run and its last.
  std::array<std::uint64_t, kNodes.size()> missing{};
  TimePoint ended{};  // the last run
};
RecordFacts read_record(const std::string& path, TimePoint since);

class Pipeline {
 public:
  // `schedule`: as the app file has it.
  Pipeline(std::string command, std::string player, const std::string& schedule);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  os::Os& os() { return *os_; }
  NodeState& state(std::size_t node) const { return state_->node(node); }
  bool has_real_time() const { return real_time_; }

  // --- the server ---
  // Each has a record of its own.
  void serve();
  TimePoint settled_since() const { return settled_since_; }  // this server's
  void signal_server(int number);
  std::optional<os::Exit> end_server(int number);  // and waits for its end
  os::ProcessId server() const { return server_->process(); }
  bool server_alive() { return server_ && !server_->wait(); }
  // The server's guardian; 0: it has none.
  pid_t guardian() const;
  const std::string& record() const { return record_; }
  const std::string& socket() const { return socket_; }
  // A place in what servers said, and whether they have said something since.
  std::size_t mark() const;
  bool said_since(std::size_t mark, const std::string& text) const;
  std::string all_said() const;

  // --- the programs ---
  void play(std::size_t node);
  os::ChildProcess& program(std::size_t node) { return *programs_.at(node); }
  bool plays(std::size_t node) const { return programs_.at(node) != nullptr; }
  void end_program(std::size_t node, int number);  // and waits for its end

  // --- what can be seen ---
  // Threads of the programs that are above the ordinary level.
  int raised() const;
  int raised(std::size_t node) const;
  // The same of threads that were there when it was asked for: fast enough to be asked all the time.
  std::vector<os::ThreadId> threads() const;
  int raised(const std::vector<os::ThreadId>& threads) const;
  // Of server and programs.
  std::size_t open_files() const;
  bool ran_since(std::size_t node, TimePoint time) const;  // a run that began since then has ended
  bool all_ran_since(TimePoint time) const;                // those that are played
  // All programs are in the server's hands, raised where that is permitted, and run. Each is asked by itself, until it
  // is so: with runs that take turns there may be no instant at which all look so.
  bool settle(Nanos within = std::chrono::seconds{10});

  // How long it took, looking twice a millisecond; none: it did not come.
  std::optional<Nanos> until(const std::function<bool()>& holds, Nanos within = std::chrono::seconds{5}) const;
  // The most that this took longer than it should.
  Nanos latest() const { return latest_; }
  // What the programs are at, for people.
  std::string describe() const;
  void pass(Nanos time) const { os_->sleep_until(os_->now() + time); }
  std::array<std::uint64_t, kNodes.size()> runs() const;

 private:
  std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::string command_;
  std::string player_;
  std::unique_ptr<os::Os> os_;
  bool real_time_ = false;
  std::string folder_;
  std::string socket_;
  std::string record_;
  int servers_ = 0;
  mutable Nanos latest_{0};
  TimePoint settled_since_ = kNever;
  std::unique_ptr<MappedState> state_;
  std::optional<os::ChildProcess> server_;
  std::array<std::unique_ptr<os::ChildProcess>, kNodes.size()> programs_;
};

}  // namespace ctn::faults
