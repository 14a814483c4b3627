// Programs that unsubscribe, as nodelets do to whose output nobody listens, under `catan ros run`.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "ros1/test/programs.h"

namespace catan_ros {
namespace {

using std::chrono::seconds;

class LazyTest : public ProgramsTest {};

// Each trigger of the one that has unsubscribed would wait for half a second, and its subchain with it.
TEST_F(LazyTest, ItsSubchainGoesOnAtItsPeriod) {
  write("app.yaml", R"(catan: 1
app: lazy
nodes: { source: { max_rate: 20Hz, fallback_rate: 20Hz }, lazy: {}, light: {} }
edges: [ source -> lazy -> light ]
subchains: { all: [source, lazy, light] }
objective: [ { response_time: [source, lazy, light], weight: 1 } ]
scheduler: { bootstrap: 300ms }
)");
  write("bind.yaml", R"(catan: 1
ros:
  source: { node: /source, timer: 20ms }
  lazy: { node: /lazy, topic: /images }
  light: { node: /light, topic: /things }
)");
  write_launcher({"source --timer 20 --out /images --counts source.json",
                  "lazy --in /images --out /things --unsubscribe-after 20 --counts lazy.json",
                  "light --in /things --counts light.json"});
  const int run = start_under_catan("-- ./launch.sh");
  ASSERT_TRUE(counts("lazy", "calls", 20)) << text_of(path("run.err"));
  const long before = counted("source", "calls");
  std::this_thread::sleep_for(seconds{4});
  EXPECT_GT(counted("source", "calls") - before, 30) << "20 times a second, not twice";
  EXPECT_EQ(counted("lazy", "calls"), 20);
  EXPECT_GE(counted("light", "calls"), 19);
  end(run, SIGTERM);
}

}  // namespace
}  // namespace catan_ros
