#include "pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "os/linux/linux_os.h"
#include "record/reader.h"

namespace ctn::faults {
namespace {

constexpr const char* kApp = R"(catan: 1
app: faults
nodes:
  eye: { fallback_rate: 50Hz }
  hand: {}
  map: { fallback_rate: 20Hz }
  log: { fallback_rate: 20Hz }
  voice: { fallback_rate: 20Hz }
edges: [ eye -> hand, eye -> map, eye -> log, eye -> voice ]
subchains: { fast: [eye, hand], slow: [map], notes: [log], talk: [voice] }
objective:
  - { response_time: [eye, hand], weight: 1 }
  - { period: map, weight: 0.1 }
  - { period: log, weight: 0.1 }
  - { period: voice, weight: 0.1 }
scheduler: { bootstrap: 200ms, bootstrap_cost: 2ms, schedule: )";
constexpr std::array<int, kNodes.size()> kCostsUs{1000, 1000, 2000, 2000, 2000};

std::size_t count_of(const std::string& folder) {
  std::error_code error;
  const std::filesystem::directory_iterator files(folder, error);
  return error ? 0 : static_cast<std::size_t>(std::distance(files, {}));
}

std::string files_of(os::ProcessId process) { return fmt::format("/proc/{}/fd", static_cast<int>(process)); }

}  // namespace

RecordFacts read_record(const std::string& path, TimePoint since) {
  RecordFacts facts;
  const Result<record::Reader> reader = record::Reader::open(path);
  if (!reader) return facts;
  std::map<NodeId, std::uint64_t> last;
  const Status runs = reader->each_run([&](const record::Run& run) {
    const auto [before, is_first] = last.try_emplace(run.node, run.number);
    if (!is_first) facts.missing.at(run.node.index()) += run.number - std::exchange(before->second, run.number) - 1;
    ++facts.runs;
    facts.ended = std::max(facts.ended, run.end);
  });
  const Status steals = reader->each_steal([&](const record::Steal& steal) {
    facts.steals += steal.thief == SubchainId(0) && steal.begin >= since ? 1 : 0;
  });
  facts.readable = runs.ok() && steals.ok();
  facts.complete = reader->ending().closed;
  return facts;
}

Pipeline::Pipeline(std::string command, std::string player, const std::string& schedule)
    : command_(std::move(command)), player_(std::move(player)), os_(os::make_linux_os()) {
  folder_ = (std::filesystem::temp_directory_path() / "catan-faults-XXXXXX").string();
  if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
  socket_ = path("socket");
  std::ofstream(path("app.yaml")) << kApp << schedule << " }\n";
  state_ = std::make_unique<MappedState>(path("state"), true);
  real_time_ = os_->real_time_facts().permitted;
  // To see what happens as it happens; nodes cannot keep the CPU from us.
  if (real_time_) static_cast<void>(os_->set_level(os_->current_thread(), os::Level::kUnscheduled));
}

Pipeline::~Pipeline() {
  programs_ = {};
  server_.reset();
  static_cast<void>(os_->set_level(os_->current_thread(), os::Level::kOrdinary));
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Pipeline::serve() {
  record_ = path(fmt::format("record-{}", ++servers_));
  Result<os::ChildProcess> started = os::ChildProcess::start(
      {"/bin/sh", "-c", R"(exec "$0" serve "$1" --socket "$2" --cpus "$3" --record "$4" --save-to "${5%/*}" 2>>"$5")",
       command_, path("app.yaml"), socket_, std::to_string(os_->online_cpus()->cpus().back()), record_, path("said")});
  if (!started) throw std::runtime_error(started.error().message());
  server_.emplace(std::move(*started));
  settled_since_ = kNever;
}

void Pipeline::signal_server(int number) { static_cast<void>(server_->signal(number)); }

std::optional<os::Exit> Pipeline::end_server(int number) {
  signal_server(number);
  std::optional<os::Exit> exit;
  until([&] { return (exit = server_->wait()).has_value(); }, std::chrono::seconds{20});
  server_.reset();
  return exit;
}

pid_t Pipeline::guardian() const {
  const int server = static_cast<int>(server_->process());
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", server))) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) {
      std::string name;
      std::getline(std::ifstream(fmt::format("/proc/{}/comm", child)) >> std::ws, name);
      if (name == "catan-guard") return child;
    }
  }
  return 0;
}

std::size_t Pipeline::mark() const {
  std::error_code none;
  const auto size = std::filesystem::file_size(path("said"), none);
  return none ? 0 : static_cast<std::size_t>(size);
}

bool Pipeline::said_since(std::size_t mark, const std::string& text) const {
  std::ifstream file(path("said"));
  file.seekg(static_cast<std::streamoff>(mark));
  const std::string said{std::istreambuf_iterator<char>(file), {}};
  return said.find(text) != std::string::npos;
}

std::string Pipeline::all_said() const {
  std::ifstream file(path("said"));
  return {std::istreambuf_iterator<char>(file), {}};
}

void Pipeline::play(std::size_t node) {
  state(node).served = 0;
  Result<os::ChildProcess> started =
      os::ChildProcess::start({player_, socket_, path("state"), kNodes.at(node), std::to_string(kCostsUs.at(node))});
  if (!started) throw std::runtime_error(started.error().message());
  programs_.at(node) = std::make_unique<os::ChildProcess>(std::move(*started));
}

void Pipeline::end_program(std::size_t node, int number) {
  static_cast<void>(programs_.at(node)->signal(number));
  until([&] { return programs_.at(node)->wait().has_value(); });
  programs_.at(node).reset();
}

int Pipeline::raised(const std::vector<os::ThreadId>& threads) const {
  return static_cast<int>(std::count_if(threads.begin(), threads.end(), [&](os::ThreadId thread) {
    const Result<os::Level> level = os_->level(thread);
    return level && *level != os::Level::kOrdinary;
  }));
}

int Pipeline::raised(std::size_t node) const {
  if (!plays(node)) return 0;
  const Result<std::vector<os::ThreadId>> threads = os_->threads(programs_.at(node)->process());
  return threads ? raised(*threads) : 0;
}

int Pipeline::raised() const {
  int count = 0;
  for (std::size_t node = 0; node < kNodes.size(); ++node) count += raised(node);
  return count;
}

std::vector<os::ThreadId> Pipeline::threads() const {
  std::vector<os::ThreadId> all;
  for (const auto& program : programs_) {
    if (!program) continue;
    const Result<std::vector<os::ThreadId>> threads = os_->threads(program->process());
    if (threads) all.insert(all.end(), threads->begin(), threads->end());
  }
  return all;
}

std::size_t Pipeline::open_files() const {
  std::size_t count = server_ ? count_of(files_of(server_->process())) : 0;
  for (const auto& program : programs_) count += program ? count_of(files_of(program->process())) : 0;
  return count;
}

// Not "nothing is under way and the newest run began since": of nodes that take turns one is always in a run.
bool Pipeline::ran_since(std::size_t node, TimePoint time) const {
  return state(node).completed >= time.time_since_epoch().count();
}

bool Pipeline::all_ran_since(TimePoint time) const {
  for (std::size_t node = 0; node < kNodes.size(); ++node) {
    if (plays(node) && !ran_since(node, time)) return false;
  }
  return true;
}

bool Pipeline::settle(Nanos within) {
  std::array<bool, kNodes.size()> settled{};
  std::array<TimePoint, kNodes.size()> served_at{};
  const auto look = [&](std::size_t node) {
    if (!plays(node)) return true;
    if (served_at.at(node) == TimePoint{}) {
      // What is lowered in the slack for a moment is raised in the next frame.
      if (state(node).served != 0 && (!real_time_ || raised(node) > 0)) served_at.at(node) = os_->now();
      return false;
    }
    return ran_since(node, served_at.at(node));
  };
  const auto all_settled = [&] {
    for (std::size_t node = 0; node < kNodes.size(); ++node) settled.at(node) = settled.at(node) || look(node);
    return std::all_of(settled.begin(), settled.end(), [](bool each) { return each; });
  };
  if (!until(all_settled, within)) return false;
  settled_since_ = std::min(settled_since_, os_->now());
  return true;
}

std::optional<Nanos> Pipeline::until(const std::function<bool()>& holds, Nanos within) const {
  const TimePoint begin = os_->now();
  while (!holds()) {
    if (os_->now() - begin > within) return std::nullopt;
    const TimePoint due = os_->now() + std::chrono::microseconds{500};
    os_->sleep_until(due);
    latest_ = std::max(latest_, os_->now() - due);
  }
  return os_->now() - begin;
}

std::string Pipeline::describe() const {
  std::string text;
  const std::int64_t now = os_->now().time_since_epoch().count();
  for (std::size_t node = 0; node < kNodes.size(); ++node) {
    const NodeState& of = state(node);
    text += fmt::format("{}{}: {}, {} threads raised, run {} began {} ms ago and ended {} ms ago",
                        node == 0 ? "" : "; ", kNodes.at(node), of.served != 0 ? "served" : "by itself", raised(node),
                        of.number.load(), (now - of.began) / 1'000'000, (now - of.ended) / 1'000'000);
  }
  constexpr std::size_t kTold = 1500;
  const std::string said = all_said();
  return text + "; the server said last: " + said.substr(said.size() - std::min(said.size(), kTold));
}

std::array<std::uint64_t, kNodes.size()> Pipeline::runs() const {
  std::array<std::uint64_t, kNodes.size()> runs{};
  for (std::size_t node = 0; node < kNodes.size(); ++node) runs.at(node) = state(node).runs;
  return runs;
}

}  // namespace ctn::faults
