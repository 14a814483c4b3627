#include "faults.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <random>

#include "config/app_file.h"
#include "os/linux/connection.h"
#include "os/linux/forked_process.h"
#include "os/linux/shared_memory.h"
#include "runtime/protocol.h"
#include "runtime/region.h"
#include "runtime/report.h"

namespace ctn::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kToldFailures = 5;
// What a faulty program does to a server takes this long.
constexpr Nanos kAttack = milliseconds{30};
// A server that has lived for so long has written a part of its record.
constexpr Nanos kWritten = milliseconds{1200};

// ---- What a hostile program says, in a process of its own

std::string request(runtime::Request::Kind kind, const std::string& node = {}) {
  return runtime::to_text(
      runtime::Request{.kind = kind, .node = node, .thread = static_cast<std::int32_t>(::getpid())});
}

// Empty: no answer within a second.
std::string ask(const os::Connection& connection, const std::string& text, os::Message& answer) {
  if (!connection.send(text)) return {};
  for (int millisecond = 0; millisecond < 1000; ++millisecond) {
    const os::Arrival arrival = connection.receive(answer);
    if (arrival == os::Arrival::kMessage) return answer.text;
    if (arrival == os::Arrival::kClosed) return {};
    ::usleep(1000);
  }
  return {};
}

std::string ask(const os::Connection& connection, const std::string& text) {
  os::Message answer;
  return ask(connection, text, answer);
}

// The server's memory; nothing if it does not give it.
std::optional<os::SharedMemory> memory_of(const os::Connection& connection) {
  os::Message answer;
  ask(connection, request(runtime::Request::Kind::kHello), answer);
  auto memory = os::SharedMemory::open(std::move(answer.descriptor));
  if (!memory) return std::nullopt;
  return std::move(*memory);
}

// Anything, anywhere.
int write_garbage(os::Os& os, const std::string& socket, unsigned seed) {
  const auto connection = os::Connection::connect(socket);
  if (!connection) return 1;
  const auto memory = memory_of(*connection);
  if (!memory) return 2;
  std::mt19937_64 random(seed);
  const std::span<std::byte> bytes = memory->bytes();
  for (const TimePoint end = os.now() + kAttack; os.now() < end; ::usleep(500)) {
    for (int i = 0; i < 2000; ++i) {
      const std::size_t at = random() % (bytes.size() / 8) * 8;
      const std::uint64_t value = random() % 3 == 0 ? random() : random() % 100;
      std::memcpy(bytes.data() + at, &value, sizeof value);
    }
  }
  return 0;
}

// A node that says of its runs what cannot be, and ends runs that it was never told to begin.
int report_lies(os::Os& os, const std::string& socket, unsigned seed) {
  const auto connection = os::Connection::connect(socket);
  if (!connection) return 1;
  const auto memory = memory_of(*connection);
  if (!memory) return 2;
  const auto text = runtime::Region::text(memory->bytes());
  if (!text) return 3;
  const auto app = config::parse_app(*text, "the server's");
  const auto region = runtime::Region::open(app->graph, memory->bytes());
  if (!region) return 4;
  if (ask(*connection, request(runtime::Request::Kind::kJoin, kNodes[kVoice])).find("done") == std::string::npos) {
    return 5;
  }
  const NodeId node = *app->graph.find_node(kNodes[kVoice]);
  runtime::SignalCell& signal = region->signal(*app->graph.node(node).subchain);
  const runtime::RingWriter reports = region->reports_writer(node);
  std::mt19937_64 random(seed);
  std::uint64_t number = 0;
  for (const TimePoint end = os.now() + kAttack; os.now() < end; ::usleep(100)) {
    const auto now = static_cast<std::uint64_t>(os.now().time_since_epoch().count());
    // Number, begin, end, CPU time, mode: of the future, the past, overlapping, more than can be.
    const std::array<std::uint64_t, 4> times{now, now + 1'000'000'000, 0, random()};
    std::vector<std::uint64_t> words(runtime::report_words(app->graph.node(node).predecessors.size()));
    for (std::uint64_t& word : words) word = random() % 2 == 0 ? times.at(random() % 4) : random() % 8;
    words[0] = random() % 2 == 0 ? ++number : random();
    reports.push(words);
    signal.completed.store(random() % 2 == 0 ? signal.completed.load() + 1000 : random());
    const std::uint32_t holder = signal.holder.load();
    if (holder != 0 && holder <= region->controller_cells()) region->controller_cell(holder - 1).wake(os);
  }
  return 0;
}

// Connects, talks nonsense, and never reads an answer.
int flood(os::Os& os, const std::string& socket) {
  std::vector<os::Connection> kept;
  for (const TimePoint end = os.now() + kAttack; os.now() < end;) {
    auto connection = os::Connection::connect(socket);
    if (!connection) {
      kept.clear();
      ::usleep(100);
      continue;
    }
    for (int i = 0; i < 20; ++i) static_cast<void>(connection->send("{\"hello\": 1}"));
    kept.push_back(std::move(*connection));
  }
  return 0;
}

// It registers, forks, and ends when it is told to; its child says things in its name and holds the connection.
int fork_and_end(const std::string& socket, const os::SyncPipe& answered, const os::SyncPipe& end) {
  const auto connection = os::Connection::connect(socket);
  if (!connection || !memory_of(*connection)) return 1;
  ask(*connection, request(runtime::Request::Kind::kJoin, kNodes[kVoice]));
  if (::fork() == 0) {
    const std::string answer = ask(*connection, request(runtime::Request::Kind::kLeave, kNodes[kVoice]));
    answered.send(answer.find("another process") != std::string::npos ? 1 : 0);
    ::usleep(200'000);
    ::_exit(0);
  }
  end.receive();
  return 0;
}

// ---- Faults

Nanos some_time(int round, Nanos max) {
  return max * ((round * 37 + 11) % 100) / 100;  // at all times of a frame and of what the server does in turn
}

void kill_server(Injection& in) {
  Pipeline& p = in.p;
  const std::vector<os::ThreadId> threads = p.threads();
  // One of ten is old enough to have written its record.
  p.pass(in.round % 10 == 0 ? Nanos{milliseconds{1300}} : some_time(in.round, milliseconds{100}));
  const TimePoint killed = p.os().now();
  p.signal_server(SIGKILL);
  in.recovers(
      0, [&] { return p.raised(threads) == 0; }, killed);
  in.recovers(
      1, [&] { return p.all_ran_since(killed); }, killed);
  p.end_server(SIGKILL);
  in.must(p.raised() == 0, "no thread is raised without a server");
  in.judge_record(false, killed);
  p.pass(milliseconds{30});
  const TimePoint back = p.os().now();
  p.serve();
  in.recovers(
      2, [&] { return p.settle(); }, back);
}

void kill_server_and_guardian(Injection& in) {
  Pipeline& p = in.p;
  const std::vector<os::ThreadId> threads = p.threads();
  p.pass(some_time(in.round, milliseconds{100}));
  const pid_t guardian = p.guardian();
  if (!in.must(guardian != 0, "there is a guardian")) return;
  const TimePoint killed = p.os().now();
  ::kill(guardian, SIGKILL);
  p.signal_server(SIGKILL);
  in.recovers(
      0, [&] { return p.raised(threads) == 0; }, killed);
  in.recovers(
      1, [&] { return p.all_ran_since(killed); }, killed);
  p.end_server(SIGKILL);
  in.must(p.raised() == 0, "no thread is raised without a server");
  in.judge_record(false, killed);
  p.serve();
  in.must(p.settle(), "the next server takes over");
}

void stop_server(Injection& in) {
  Pipeline& p = in.p;
  const std::vector<os::ThreadId> threads = p.threads();
  p.pass(some_time(in.round, milliseconds{100}));
  const TimePoint stopped = p.os().now();
  p.signal_server(SIGSTOP);
  in.recovers(
      0, [&] { return p.raised(threads) == 0; }, stopped);
  in.recovers(
      1, [&] { return p.all_ran_since(stopped + milliseconds{1}); }, stopped);
  p.pass(milliseconds{50});
  in.must(p.raised() == 0, "no thread is raised by a server that is stopped");
  const TimePoint goes_on = p.os().now();
  p.signal_server(SIGCONT);
  in.recovers(
      2, [&] { return p.settle(); }, goes_on);
}

void kill_node(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t node = static_cast<std::size_t>(in.round) % 3;
  p.pass(some_time(in.round, milliseconds{20}));
  const std::size_t mark = p.mark();
  const TimePoint killed = p.os().now();
  static_cast<void>(p.program(node).signal(SIGKILL));
  in.recovers(
      0, [&] { return p.said_since(mark, fmt::format("node {} is gone", kNodes.at(node))); }, killed);
  const bool in_chain = node == kEye || node == kHand;
  in.must(p.said_since(mark, "broken until it is back: eye -> hand") == in_chain, "the broken chain is named");
  p.end_program(node, SIGKILL);
  in.watch();
  in.others_run(in_chain ? std::vector<std::size_t>{kMap, kLog, kVoice} : std::vector<std::size_t>{kEye, kLog, kVoice},
                milliseconds{100});
  const TimePoint back = p.os().now();
  p.play(node);
  in.recovers(
      1, [&] { return p.ran_since(node, back) && p.state(node).served != 0; }, back);
  in.must(p.settle(), "all run as before");
}

// Three at a time, since it takes a second until a run counts as hanging.
// So many runs apart, hangs are the exceptions that estimates of what a run costs leave out.
constexpr std::uint64_t kRunsBetweenHangs = 30;
constexpr std::array<std::size_t, 3> kThree{kMap, kLog, kVoice};
constexpr std::array<const char*, 3> kTheirSubchains{"slow", "notes", "talk"};

void hang(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t mark = p.mark();
  std::array<bool, 3> told{};
  for (const std::size_t node : kThree) p.state(node).hang = 1;
  const auto all_told = [&] {
    for (std::size_t i = 0; i < kThree.size(); ++i) {
      if (told.at(i)) continue;
      told.at(i) = p.said_since(mark, fmt::format("a run of subchain {} hangs", kTheirSubchains.at(i)));
      if (told.at(i))
        in.recovers(
            0, [] { return true; }, TimePoint{Nanos{p.state(kThree.at(i)).began.load()}});
    }
    return std::count(told.begin(), told.end(), true) == 3;
  };
  in.must(p.until(all_told).has_value(), "hangs are reported");
  in.watch();
  in.others_run({kEye, kHand}, milliseconds{100});
  const TimePoint repaired = p.os().now();
  for (const std::size_t node : kThree) p.state(node).hang = 0;
  in.recovers(
      1, [&] { return p.all_ran_since(repaired); }, repaired);
  in.must(p.settle(), "all run as before");
  const auto before = p.runs();
  const auto ran_enough = [&] {
    return std::all_of(kThree.begin(), kThree.end(),
                       [&](std::size_t node) { return p.runs().at(node) >= before.at(node) + kRunsBetweenHangs; });
  };
  in.must(p.until(ran_enough).has_value(), "runs are as before");
}

void stop_program(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t mark = p.mark();
  const TimePoint begin = p.os().now();
  for (const std::size_t node : kThree) static_cast<void>(p.program(node).signal(SIGSTOP));
  std::array<bool, 3> told{};
  const auto all_told = [&] {
    for (std::size_t i = 0; i < kThree.size(); ++i) {
      if (told.at(i)) continue;
      told.at(i) = p.said_since(mark, fmt::format("a run of subchain {} hangs", kTheirSubchains.at(i)));
      if (told.at(i))
        in.recovers(
            0, [] { return true; }, begin);
    }
    return std::count(told.begin(), told.end(), true) == 3;
  };
  in.must(p.until(all_told).has_value(), "stopped programs are reported");
  in.watch();
  in.others_run({kEye, kHand}, milliseconds{100});
  const TimePoint goes_on = p.os().now();
  for (const std::size_t node : kThree) static_cast<void>(p.program(node).signal(SIGCONT));
  in.recovers(
      1, [&] { return p.all_ran_since(goes_on); }, goes_on);
  in.must(p.settle(), "all run as before");
}

// An overrun of the first node of the subchain that ranks highest: it goes on in the slots of others. What is measured
// holds the long run itself, too.
void overrun(Injection& in) {
  Pipeline& p = in.p;
  p.pass(some_time(in.round, milliseconds{40}));
  constexpr Nanos kOverrun = milliseconds{8};
  p.state(kEye).overran = 0;
  const TimePoint begin = p.os().now();
  in.watch();
  p.state(kEye).overrun = kOverrun.count();
  const auto all_ran = [&] {
    const std::int64_t ended = p.state(kEye).overran;
    return ended != 0 && p.all_ran_since(TimePoint{Nanos{ended}});
  };
  in.recovers(0, all_ran, begin);
  in.others_run({kMap, kLog, kVoice}, milliseconds{100});
}

void lie(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t mark = p.mark();
  const os::ForkedProcess liar([&] { return report_lies(p.os(), p.socket(), static_cast<unsigned>(in.round)); });
  in.watch();
  in.others_run({kEye, kHand, kMap, kLog}, kAttack + milliseconds{30});
  const TimePoint end = p.os().now();
  in.recovers(
      0, [&] { return p.said_since(mark, "node voice is gone"); }, end);
  in.recovers(
      1, [&] { return p.all_ran_since(end); }, end);
}

void write_anything(Injection& in) {
  Pipeline& p = in.p;
  {
    os::ForkedProcess vandal([&] { return write_garbage(p.os(), p.socket(), static_cast<unsigned>(in.round)); });
    in.must(vandal.join() == 0, "it could write");
  }
  const TimePoint end = p.os().now();
  in.must(p.server_alive(), "the server lives");
  in.may_recover(
      0, [&] { return p.all_ran_since(end); }, end);
  p.pass(milliseconds{50});
  const std::optional<os::Exit> exit = p.end_server(SIGTERM);
  in.must(exit == os::Exit{},
          exit ? fmt::format("the server ends in order, not with {} and signal {}", exit->code, exit->signal)
               : "the server ends in order, not never");
  in.must(p.raised() == 0, "no thread is raised without a server");
  in.judge_record(true, {});
  const TimePoint back = p.os().now();
  p.serve();
  in.recovers(
      1, [&] { return p.settle(); }, back);
}

void fork_client(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t mark = p.mark();
  const os::SyncPipe answered;
  const os::SyncPipe end;
  os::ForkedProcess client([&] { return fork_and_end(p.socket(), answered, end); });
  in.must(p.until([&] { return p.said_since(mark, "subchain talk runs"); }).has_value(), "it registers");
  in.must(answered.receive() == 1, "its child is refused");
  const TimePoint ended = p.os().now();
  end.send();
  in.recovers(
      0, [&] { return p.said_since(mark, "node voice is gone: its process has ended"); }, ended);
  in.must(client.join() == 0, "it ends");
  in.watch();
  in.others_run({kEye, kHand, kMap, kLog}, milliseconds{50});
}

void flood_server(Injection& in) {
  Pipeline& p = in.p;
  const std::size_t files = p.open_files();
  os::ForkedProcess flooding([&] { return flood(p.os(), p.socket()); });
  in.watch();
  in.others_run({kEye, kHand, kMap, kLog, kVoice}, kAttack + milliseconds{20});
  in.must(flooding.join() == 0, "it ends");
  const TimePoint end = p.os().now();
  in.must(p.server_alive(), "the server lives");
  in.recovers(
      0, [&] { return p.open_files() <= files; }, end);
}

// ---- Driving

bool plays(const Fault& fault, std::size_t node) {
  return std::find(fault.absent.begin(), fault.absent.end(), node) == fault.absent.end();
}

}  // namespace

bool Injection::must(bool holds, const std::string& what) {
  if (holds) return true;
  survived_ = false;
  if (report_.failures.size() < kToldFailures) report_.failures.push_back(fmt::format("{}: not so: {}", round, what));
  return false;
}

bool Injection::recovers(std::size_t recovery, const std::function<bool()>& holds, TimePoint since) {
  const bool recovered = p.until(holds, timeout_).has_value();
  Recovery& to = report_.recoveries.at(recovery);
  if (recovered) to.ms.push_back(to_millis(p.os().now() - since).count());
  return must(recovered, recovered ? to.until : to.until + "; " + p.describe());
}

void Injection::judge_record(bool in_order, TimePoint killed) {
  const RecordFacts facts = read_record(p.record(), report_.begin);
  ++report_.records;
  std::uint64_t missing = 0;
  for (std::size_t node = 0; node < kNodes.size(); ++node) missing += p.plays(node) ? facts.missing.at(node) : 0;
  bool whole = true;
  const auto is = [&](bool good, const std::string& what) {
    whole = whole && good;
    if (!good && report_.failures.size() < kToldFailures)
      report_.failures.push_back(fmt::format("{}: {}", round, what));
  };
  is(facts.readable, "the record cannot be read");
  is(!in_order || facts.complete, "the record was not closed");
  is(missing <= gaps_, fmt::format("{} runs are missing in the record", missing));
  if (whole) ++report_.records_whole;
  report_.steals = facts.steals;
  if (in_order || killed - p.settled_since() < kWritten) return;
  is(facts.runs > 0, "nothing is in the record");
  report_.unwritten_ms = std::max(report_.unwritten_ms, to_millis(killed - facts.ended).count());
}

void Injection::may_recover(std::size_t recovery, const std::function<bool()>& holds, TimePoint since) {
  if (p.until(holds, timeout_)) {
    report_.recoveries.at(recovery).ms.push_back(to_millis(p.os().now() - since).count());
  } else {
    report_.recoveries.at(recovery).all = false;
  }
}

void Injection::watch() {
  runs_then_ = p.runs();
  then_ = p.os().now();
}

// A machine that others use may take more of so short a time than the nodes may lose: then it is longer, by kStolen at
// most.
void Injection::others_run(const std::vector<std::size_t>& others, Nanos meanwhile) {
  constexpr Nanos kStolen = milliseconds{300};
  constexpr Nanos kPause = milliseconds{50};
  struct Kept {
    double runs;
    double expected;
  };
  std::vector<Kept> kept;
  const auto enough = [&](const Kept& node) { return node.runs + 1.0 >= min_ * node.expected; };
  for (TimePoint end = then_ + meanwhile; end <= then_ + meanwhile + kStolen; end += kPause) {
    p.os().sleep_until(end);
    const auto after = p.runs();
    const double time = in_seconds(p.os().now() - then_);
    kept.clear();
    for (const std::size_t node : others)
      kept.push_back({static_cast<double>(after.at(node) - runs_then_.at(node)), usual_.at(node) * time});
    if (std::all_of(kept.begin(), kept.end(), enough)) break;
  }
  for (std::size_t i = 0; i < others.size(); ++i) {
    must(enough(kept[i]), fmt::format("{} keeps its rate ({:.0f} of {:.1f} runs)", kNodes.at(others[i]), kept[i].runs,
                                      kept[i].expected));
    runs_ += kept[i].runs;
    expected_ += kept[i].expected;
  }
}

FaultReport inject(const Fault& fault, int times, const Place& place) {
  FaultReport report;
  report.fault = fault.name;
  for (const std::string& recovery : fault.recoveries) report.recoveries.push_back({recovery, {}});
  Pipeline p(place.command, place.player, fault.in_frames ? "frames" : "auto");
  p.serve();
  for (std::size_t node = 0; node < kNodes.size(); ++node) {
    if (plays(fault, node)) p.play(node);
  }
  const auto fail = [&](const std::string& what) { report.failures.push_back(what); };
  if (!p.settle()) return fail("nothing runs: " + p.all_said()), report;
  // There is a plan that rests on measurements, and it runs.
  p.pass(milliseconds{1000});
  const auto before = p.runs();
  p.pass(milliseconds{fault.with_server ? 1000 : 1});
  std::array<double, kNodes.size()> usual{};
  for (std::size_t node = 0; node < kNodes.size(); ++node) {
    usual.at(node) = static_cast<double>(p.runs().at(node) - before.at(node));
  }
  const auto files = static_cast<int>(p.open_files());
  double runs = 0.0;
  double expected = 0.0;
  int injections = 0;
  report.begin = p.os().now();
  while (report.injected < times && place.go_on()) {
    Injection in(p, injections++, report);
    in.usual_ = usual;
    in.timeout_ = fault.timeout;
    in.min_ = fault.others_min;
    in.gaps_ = fault.untrue ? ~std::uint64_t{0} : 0;
    fault.inject(in);
    runs += in.runs_;
    expected += in.expected_;
    report.injected += fault.at_once;
    if (in.survived()) report.survived += fault.at_once;
    if (!p.server_alive()) return fail("the server is gone: " + p.all_said()), report;
  }
  if (expected > 0.0) report.others = runs / expected;
  p.until([&] { return static_cast<int>(p.open_files()) <= files; }, seconds{1});
  report.files_left = static_cast<int>(p.open_files()) - files;
  for (std::size_t node = 0; node < kNodes.size(); ++node) {
    if (p.state(node).went_back != 0) fail(fmt::format("{}'s runs were numbered from the beginning", kNodes.at(node)));
  }
  if (p.end_server(SIGTERM) != os::Exit{}) fail("the server did not end in order");
  report.raised_left = p.raised();
  Injection last(p, injections, report);
  last.gaps_ = fault.untrue ? ~std::uint64_t{0} : static_cast<std::uint64_t>(injections * fault.gaps);
  last.judge_record(true, {});
  report.observer_late_ms = to_millis(p.latest()).count();
  if (fault.in_frames && report.steals < static_cast<std::uint64_t>(report.injected)) {
    fail(fmt::format("only {} steals", report.steals));
  }
  return report;
}

const std::vector<Fault>& all_faults() {
  static const std::vector<Fault> faults{
      {.name = "server killed",
       .recoveries = {"no thread is raised", "every node has run again", "the next server: all nodes scheduled"},
       .inject = kill_server,
       .with_server = false},
      {.name = "server and guardian killed",
       .recoveries = {"no thread is raised", "every node has run again"},
       .inject = kill_server_and_guardian,
       .with_server = false},
      {.name = "server stopped",
       .recoveries = {"no thread is raised", "every node has run again", "it goes on: all nodes scheduled"},
       .inject = stop_server,
       .with_server = false},
      {.name = "node killed",
       .recoveries = {"the server says so", "it is back: it runs"},
       .inject = kill_node,
       .gaps = 1},
      {.name = "node hangs",
       .recoveries = {"it is suspended", "it ends: all run again"},
       .inject = hang,
       .at_once = 3,
       .by_design = std::chrono::seconds{1}},
      {.name = "program stopped",
       .recoveries = {"the server says so", "it goes on: all run again"},
       .inject = stop_program,
       .at_once = 3,
       .by_design = std::chrono::seconds{1}},
      {.name = "run takes 8 ms longer",
       .recoveries = {"every node has run again"},
       .inject = overrun,
       .others_min = 0.25},
      {.name = "the same in frames",
       .recoveries = {"every node has run again"},
       .inject = overrun,
       .in_frames = true,
       .others_min = 0.25},
      {.name = "client lies",
       .recoveries = {"the server drops it", "every node has run again"},
       .inject = lie,
       .others_min = 0.2,  // it wakes the controller without end
       .absent = {kVoice}},
      {.name = "client writes garbage",
       .recoveries = {"every node has run again", "the next server: all nodes scheduled"},
       .inject = write_anything,
       .with_server = false,
       .untrue = true,
       .timeout = seconds{3}},
      {.name = "client forks and ends",
       .recoveries = {"the server says so"},
       .inject = fork_client,
       .absent = {kVoice}},
      {.name = "flood of registrations", .recoveries = {"nothing of it is left"}, .inject = flood_server},
  };
  return faults;
}

}  // namespace ctn::faults
