// Subchains with fixed priorities on the real system: phases against each other, and triggers by outputs, as the record
// has them. Bounds are generous: a busy machine is late, but neither loses triggers nor shifts a grid.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "config/app_file.h"
#include "os/linux/linux_os.h"
#include "os/testing/requires_real_time.h"
#include "policy/testing/given_places.h"
#include "record/reader.h"
#include "runtime/engine.h"

namespace ctn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanos kPeriod = milliseconds{20};
constexpr Nanos kApart = milliseconds{8};

const char* const kLiveApp = R"(
catan: 1
app: live
nodes: { lead: {}, aside: {}, follow: {} }
edges: [ lead -> follow ]
objective:
  - { response_time: [lead], weight: 1 }
  - { response_time: [aside], weight: 1 }
  - { response_time: [follow], weight: 1 }
scheduler: { bootstrap: 200ms }
)";

class LiveFixedPriorities : public ::testing::Test {
 protected:
  void burn(Nanos duration) const {
    const Nanos end = os->thread_cpu_time() + duration;
    while (os->thread_cpu_time() < end) {
    }
  }

  std::unique_ptr<os::Os> os = os::make_linux_os();
};

TEST_F(LiveFixedPriorities, KeepTheirPhasesAndFollowOutputs) {
  CATAN_REQUIRE_REAL_TIME(*os);
  Result<graph::App> parsed = config::parse_app(kLiveApp, "live.yaml");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message();
  const graph::App app = *parsed;
  const auto id = [&](const char* name) { return *app.graph.find_subchain(name); };
  const int cpu = os->affinity(os->current_thread())->cpus().front();
  std::vector<policy::SubchainPlace> places(3);
  places[id("lead").index()] = policy::place_by_phase(2, cpu, kPeriod, Nanos{0}, milliseconds{2});
  places[id("aside").index()] = policy::place_by_phase(1, cpu, kPeriod, kApart);
  places[id("follow").index()] = policy::place_after(0, cpu, id("lead"), 2, 2 * kPeriod);

  const std::string path = testing::TempDir() + fmt::format("catan_live_priorities_{}.catan", ::getpid());
  std::remove(path.c_str());
  auto engine = runtime::Engine::create(app, *os,
                                        {.policy = std::make_shared<policy::GivenPlaces>(places),
                                         .cpus = os::CpuSet{cpu},
                                         .record = path,
                                         .note = {},
                                         .on_notice = {}});
  ASSERT_TRUE(engine.ok()) << engine.error().message();
  for (const char* name : {"lead", "aside", "follow"}) {
    const bool leads = std::string(name) == "lead";
    (*engine)->wiring().set_body(name, [this, leads](ctn::Run& run) {
      // Each tenth run uses four times its budget.
      burn(leads && run.number() % 10 == 0 ? milliseconds{8} : milliseconds{1});
    });
  }
  ASSERT_TRUE((*engine)->start().ok());
  os->sleep_until(os->now() + seconds{2});
  ASSERT_TRUE((*engine)->stop().ok());

  const auto reader = record::Reader::open(path);
  ASSERT_TRUE(reader.ok()) << reader.error().message();
  std::vector<std::vector<record::Trigger>> triggers(3);
  std::vector<record::Run> leading;
  std::vector<record::Overrun> overruns;
  ASSERT_TRUE(
      reader
          ->each_trigger([&](const record::Trigger& trigger) { triggers[trigger.subchain.index()].push_back(trigger); })
          .ok());
  ASSERT_TRUE(reader
                  ->each_run([&](const record::Run& run) {
                    if (run.node == *app.graph.find_node("lead")) leading.push_back(run);
                  })
                  .ok());
  ASSERT_TRUE(reader->each_overrun([&](const record::Overrun& overrun) { overruns.push_back(overrun); }).ok());
  std::remove(path.c_str());

  const auto phase_of = [&](const char* name, Nanos phase) {
    EXPECT_GT(triggers[id(name).index()].size(), 60U) << name;
    for (const record::Trigger& trigger : triggers[id(name).index()]) {
      EXPECT_EQ((trigger.due.time_since_epoch() - phase) % kPeriod, Nanos{0}) << name << " " << trigger.number;
      EXPECT_GE(trigger.sent, trigger.due);
    }
  };
  phase_of("lead", Nanos{0});
  phase_of("aside", kApart);

  // Each by the output of a run that had ended, every second one.
  const std::vector<record::Trigger>& followed = triggers[id("follow").index()];
  EXPECT_GT(followed.size(), 30U);
  for (const record::Trigger& trigger : followed) {
    std::size_t ended = 0;
    while (ended < leading.size() && leading[ended].end < trigger.due) ++ended;
    ASSERT_LT(ended, leading.size());
    EXPECT_EQ(leading[ended].end, trigger.due) << "due when the output came";
    EXPECT_GE(trigger.sent, trigger.due);
  }
  EXPECT_LE(followed.size(), leading.size() / 2 + 1);

  EXPECT_GT(overruns.size(), 3U);
  for (const record::Overrun& overrun : overruns) {
    EXPECT_EQ(overrun.subchain, id("lead"));
    EXPECT_GT(overrun.cpu, milliseconds{2});
    EXPECT_LE(overrun.cpu, milliseconds{8});
  }
}

}  // namespace
}  // namespace ctn
