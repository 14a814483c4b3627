// What right bindings mean. What wrong ones are told is in tests/malformed.
#include "config/illixr_binding.h"

#include <gtest/gtest.h>

#include "config/app_file.h"

namespace ctn::config {
namespace {

constexpr std::string_view kHeadset = R"(catan: 1
app: headset
nodes:
  pose: { illixr: { plugin: rk4_integrator, topic: imu } }
  imu: { unscheduled: true, period: 5ms, illixr: { plugin: offline_imu, output: [imu] } }
  show: {}
edges: [imu -> pose -> show]
objective: [{ response_time: [imu, pose, show], weight: 1 }]
)";

TEST(IllixrBinding, OfTheAppFile) {
  const auto app = parse_app(kHeadset, "app.yaml");
  ASSERT_TRUE(app.ok()) << app.error().message();
  const auto bindings = illixr_bindings(kHeadset, "app.yaml", *app);
  ASSERT_TRUE(bindings.ok()) << bindings.error().message();
  ASSERT_EQ(bindings->size(), 2U);
  const auto& [pose, callback] = (*bindings)[0];
  EXPECT_EQ(app->graph.node(pose).name, "pose");
  EXPECT_EQ(callback.plugin, "rk4_integrator");
  EXPECT_EQ(callback.topic, "imu");
  const auto& [imu, loop] = (*bindings)[1];
  EXPECT_EQ(app->graph.node(imu).name, "imu");
  EXPECT_EQ(loop.plugin, "offline_imu");
  EXPECT_TRUE(loop.topic.empty());
  EXPECT_EQ(loop.outputs, std::vector<std::string>{"imu"});
  EXPECT_TRUE(callback.outputs.empty());
}

TEST(IllixrBinding, AnAppNeedsNone) {
  constexpr std::string_view kText = "catan: 1\napp: a\nnodes: { one: {} }\nobjective: [{ period: one, weight: 1 }]\n";
  const auto app = parse_app(kText, "app.yaml");
  ASSERT_TRUE(app.ok()) << app.error().message();
  EXPECT_TRUE(illixr_bindings(kText, "app.yaml", *app)->empty());
}

}  // namespace
}  // namespace ctn::config
