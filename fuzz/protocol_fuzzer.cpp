// What programs say to a server: whatever it is, each message has one answer that a client understands, and when the
// programs have gone nothing of them is left, and each of their threads has the level that it had.
// Program d alone may control the server; no other changes anything.
//
// The input is a row of lines. The first character of each says who speaks ('a' to 'd'), the rest is the message; an
// upper-case letter is a message that another process wrote on that program's connection, '-' makes program a end.
#include <cctype>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

#include "config/app_file.h"
#include "os/fake/fake_os.h"
#include "runtime/registry.h"
#include "runtime/scheduler.h"

namespace {

using namespace ctn;

constexpr const char* kApp = R"(catan: 1
app: fuzzed
nodes: { imu: { unscheduled: true, period: 5ms }, eye: {}, hand: {}, map: {}, motor: { external: true } }
edges: [ imu -> hand, eye -> hand -> motor, eye -> map ]
subchains: { fast: [eye, hand] }
objective: [ { response_time: [eye, hand], weight: 1 }, { period: map, weight: 1 } ]
)";

// A server without a socket. Made once; programs come and go. Their threads are this one's, which sleep for good.
struct World {
  World() {
    memory = std::make_unique<runtime::LocalRegion>(app.graph, 1);
    runtime::SchedulerOptions options;
    options.policy = *policy::make_policy("catan");
    scheduler = *runtime::Scheduler::create(app, fake, std::move(options), os::CpuSet{0}, memory->region());
    if (!scheduler->prepare()) std::abort();
    constexpr int kThreads = 3;
    for (int count = 0; count < kThreads; ++count) {
      threads.push_back(fake.spawn("thread", [this] { fake.sleep_until(TimePoint::max()); }));
    }
    fake.sleep_until(fake.now() + std::chrono::milliseconds{1});
  }

  os::FakeOs fake{os::fake_topology(1)};
  graph::App app = *config::parse_app(kApp, "app.yaml");
  std::unique_ptr<runtime::LocalRegion> memory;
  std::unique_ptr<runtime::Scheduler> scheduler;
  std::vector<std::unique_ptr<os::Thread>> threads;
  std::uint64_t changes = 0;
};

void speak(runtime::Registry& registry, const std::map<char, runtime::Registry::ProgramId>& programs, World& world,
           std::string_view line) {
  const char who = static_cast<char>(std::tolower(static_cast<unsigned char>(line.front())));
  const auto program = programs.find(who);
  if (program == programs.end()) return;
  const os::ProcessId own = world.fake.current_process();
  const os::ProcessId sender = who == line.front() ? own : os::ProcessId{static_cast<std::int32_t>(own) + 1};
  const runtime::Registry::Answer answer = registry.handle(program->second, sender, line.substr(1));
  const Status said = runtime::parse_reply(answer.text);
  if (!said && said.error().kind() != ErrorKind::kCaller) std::abort();
  const bool names_app = runtime::parse_app_reply(answer.text).ok();
  if (names_app && (!said || sender != own || who != 'd')) std::abort();
  using Attached = ctn::runtime::Registry::Attached;
  if (answer.attached != Attached::kNone && (!said || sender != own)) std::abort();
  if ((answer.attached == Attached::kStatus || answer.attached == Attached::kFlight) && who != 'd') std::abort();
  if (line.find("change") == std::string_view::npos) return;  // a snapshot costs more than all of the above
  const std::uint64_t changes = world.scheduler->snapshot().changes;
  if (changes != world.changes && (!said || sender != own || who != 'd')) std::abort();
  world.changes = changes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static World& world = *new World;  // its threads never end
  runtime::Registry registry(world.fake, *world.scheduler);
  std::map<char, runtime::Registry::ProgramId> programs;
  for (const char name : {'a', 'b', 'c', 'd'}) {
    programs[name] = registry.enter(world.fake.current_process(), name == 'd');
  }
  std::string_view text(reinterpret_cast<const char*>(data), size);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line == "-") {
      registry.leave(programs['a'], "it has ended");
      programs['a'] = registry.enter(world.fake.current_process());
    } else if (!line.empty()) {
      speak(registry, programs, world, line);
    }
    registry.find_threads();
  }
  for (const auto& [name, program] : programs) registry.leave(program, "it has ended");
  for (std::size_t node = 0; node < world.app.graph.nodes().size(); ++node) {
    if (world.app.graph.nodes()[node].external) continue;
    if (!world.scheduler->threads(NodeId(node)).empty()) std::abort();
  }
  const auto threads = world.fake.threads(world.fake.current_process());
  for (const os::ThreadId thread : *threads) {
    if (*world.fake.level(thread) != os::Level::kOrdinary) std::abort();
  }
  return 0;
}
