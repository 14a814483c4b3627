// `catan plan --format cie`: the plan as the thread configuration of Autoware's callback-isolated executor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "command_test.h"
#include "config/yaml.h"

namespace ctn::test {
namespace {

using config::Value;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kRobot = R"(catan: 1
app: robot
nodes:
  camera: { unscheduled: true, period: 33ms, ros: { node: /camera, timer: 33ms } }
  detect: { ros: { node: /perception/detector, topic: /image } }
  plan: { ros: { node: /planner, topic: /people } }
  map: { ros: { node: /mapper, timer: 100ms } }
edges: [camera -> detect -> plan, camera -> map]
subchains: { track: [detect, plan], map: [map] }
objective:
  - { response_time: [camera, detect, plan], weight: 1 }
  - { period: map, weight: 0.1 }
)";
constexpr const char* kRobotCosts = "camera: 1ms\ndetect: 20ms\nplan: 5ms\nmap: 10ms\n";

// As the executor's own tool writes it, with what is in each node's groups.
constexpr const char* kTemplate = R"(hardware_info:
  cpu_family: 6
  model_name: Some(R) CPU @ 2.10GHz
callback_groups:
  - id: /camera@Timer(33000000)
    affinity: ~
    policy: SCHED_OTHER
    nice: 0

  - id: /mapper@Service(/mapper/save)@Timer(100000000)@Waitable
    affinity: ~
    policy: SCHED_OTHER
    nice: 0

  - id: /perception/detector@Subscription(/parameter_events)
    affinity: [1, 0]
    policy: SCHED_OTHER
    nice: 5

  - id: /perception/detector@Subscription(/image)
    affinity: ~
    policy: SCHED_OTHER
    nice: 0

  - id: /planner@Subscription(/parameter_events)@Subscription(/people)
    affinity: ~
    policy: SCHED_OTHER
    nice: 0
non_ros_threads:
  - id: driver
    affinity: ~
    policy: SCHED_OTHER
    nice: 0
)";

std::string file_of(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path) << text;
  return path;
}

// Tests run beside one another.
std::string own_file(const std::string& name, const std::string& text) {
  return file_of(testing::UnitTest::GetInstance()->current_test_info()->name() + ("_" + name), text);
}

Outcome threads_of(const std::string& arguments, const std::string& app = kRobot,
                   const std::string& costs = kRobotCosts) {
  return run_catan("plan " + own_file("robot.yaml", app) + " --costs " + own_file("costs.yaml", costs) +
                       " --effort 0.02 --format cie " + arguments,
                   testing::TempDir());
}

std::string with_template(const std::string& text) { return " --template " + own_file("template.yaml", text); }

const Value* value_of(const Value& map, const std::string& key) {
  const auto found =
      std::find_if(map.entries.begin(), map.entries.end(), [&](const config::Entry& one) { return one.key == key; });
  return found == map.entries.end() ? nullptr : &found->value;
}

Value read(const Outcome& outcome) {
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  auto root = config::parse_yaml(outcome.out, "threads.yaml", "docs/ros2.md");
  EXPECT_TRUE(root) << outcome.out;
  return root ? std::move(*root) : Value{};
}

// Of the callback group with that ID; an empty value: there is none.
Value group(const Value& root, const std::string& id) {
  const Value* const groups = value_of(root, "callback_groups");
  for (const Value& one : groups != nullptr ? groups->items : std::vector<Value>{}) {
    if (value_of(one, "id")->text == id) return one;
  }
  ADD_FAILURE() << "no group " << id;
  return {};
}

std::string text_of(const Value& map, const std::string& key) {
  const Value* const value = value_of(map, key);
  if (value == nullptr) return "none";
  if (value->kind != config::ValueKind::kSequence) return value->text;
  std::string text;
  for (const Value& item : value->items) text += (text.empty() ? "" : ",") + item.text;
  return text;
}

int priority_of(const Value& root, const std::string& id) {
  const Value found = group(root, id);
  EXPECT_EQ(text_of(found, "policy"), "SCHED_FIFO") << id;
  return std::stoi(text_of(found, "priority"));
}

TEST(CiePlan, WithoutATemplateEachCallbackIsAGroup) {
  const Outcome outcome = threads_of("--cores 1");
  const Value root = read(outcome);
  ASSERT_EQ(value_of(root, "callback_groups")->items.size(), 4U) << outcome.out;
  const int camera = priority_of(root, "/camera@Timer(33000000)");
  const int detect = priority_of(root, "/perception/detector@Subscription(/image)");
  const int plan = priority_of(root, "/planner@Subscription(/people)");
  const int map = priority_of(root, "/mapper@Timer(100000000)");
  EXPECT_EQ(detect, plan) << "one subchain, one priority";
  EXPECT_NE(detect, map) << "each subchain of a core has its own";
  EXPECT_GT(camera, std::max(detect, map)) << "what runs by itself is above all";
  EXPECT_GE(std::min(detect, map), 1);
  EXPECT_EQ(text_of(group(root, "/mapper@Timer(100000000)"), "affinity"), "0");
  EXPECT_THAT(outcome.err, HasSubstr("alone in its callback group"));
}

TEST(CiePlan, CoresAreTheCpusThatAreNamed) {
  const Value root = read(threads_of("--cores 2 --cpus 2,5"));
  EXPECT_EQ(text_of(group(root, "/camera@Timer(33000000)"), "affinity"), "2,5") << "any of them";
  const std::string detect = text_of(group(root, "/perception/detector@Subscription(/image)"), "affinity");
  const std::string map = text_of(group(root, "/mapper@Timer(100000000)"), "affinity");
  EXPECT_TRUE(detect == "2" || detect == "5") << detect;
  EXPECT_TRUE(map == "2" || map == "5") << map;
  EXPECT_NE(detect, map);
}

TEST(CiePlan, TheTemplatesGroupsKeepTheirIds) {
  const Outcome outcome = threads_of("--cores 1" + with_template(kTemplate));
  const Value root = read(outcome);
  EXPECT_EQ(text_of(*value_of(root, "hardware_info"), "model_name"), "Some(R) CPU @ 2.10GHz");
  ASSERT_EQ(value_of(root, "callback_groups")->items.size(), 5U);
  priority_of(root, "/camera@Timer(33000000)");
  priority_of(root, "/mapper@Service(/mapper/save)@Timer(100000000)@Waitable");
  priority_of(root, "/perception/detector@Subscription(/image)");
  priority_of(root, "/planner@Subscription(/parameter_events)@Subscription(/people)");
  const Value other = group(root, "/perception/detector@Subscription(/parameter_events)");
  EXPECT_EQ(text_of(other, "policy"), "SCHED_OTHER") << "no node of the app: as it was";
  EXPECT_EQ(text_of(other, "nice"), "5");
  EXPECT_EQ(text_of(other, "affinity"), "1,0");
  EXPECT_EQ(text_of(value_of(root, "non_ros_threads")->items.at(0), "id"), "driver");
  EXPECT_THAT(outcome.err, Not(HasSubstr("alone in its callback group")));
  EXPECT_EQ(read(threads_of("--cores 1" + with_template(outcome.out))).entries.size(), root.entries.size())
      << "what it writes it can read again";
}

// The robot's, but that map is triggered by time, or by what else may be.
std::string with_map_by(const std::string& trigger) {
  const std::string before = "map: { ros:";
  std::string app = kRobot;
  return app.replace(app.find(before), before.size(), "map: { trigger: " + trigger + ", ros:");
}

TEST(CiePlan, RatesAreSaidSinceTheExecutorHasNone) {
  const Outcome outcome = threads_of("--cores 1", with_map_by("time"));
  EXPECT_THAT(outcome.out, HasSubstr("# map: subchain map, "));
  EXPECT_THAT(outcome.out, HasSubstr("budget "));
  EXPECT_THAT(outcome.err, HasSubstr("map is planned every "));
  EXPECT_THAT(outcome.err, HasSubstr("the program's timer has 100.000ms"));
}

// Whatever triggers it as planned, its program's timer does there.
TEST(CiePlan, ATimerThatIsToFollowOutputsIsSaidToo) {
  const Outcome outcome = threads_of("--cores 1", with_map_by("arrival"));
  EXPECT_THAT(outcome.err, HasSubstr("map is planned for "));
  EXPECT_THAT(outcome.err, HasSubstr("of camera; the program's timer has 100.000ms"));
}

// The plan would have kept map to a rate; that executor calls it ten times a second, for 0.5 s of CPU time.
TEST(CiePlan, AThreadThatWouldNeverGiveWayIsAnOrdinaryOne) {
  const Outcome outcome = threads_of("--cores 1", kRobot, "camera: 1ms\ndetect: 20ms\nplan: 5ms\nmap: 50ms\n");
  const Value root = read(outcome);
  EXPECT_EQ(text_of(group(root, "/mapper@Timer(100000000)"), "policy"), "SCHED_OTHER") << outcome.out;
  EXPECT_EQ(text_of(group(root, "/mapper@Timer(100000000)"), "priority"), "0");
  EXPECT_EQ(text_of(group(root, "/mapper@Timer(100000000)"), "affinity"), "0");
  EXPECT_GE(priority_of(root, "/perception/detector@Subscription(/image)"), 1) << "which its core can keep up with";
  EXPECT_THAT(outcome.err, HasSubstr("map is called more often than its CPU can run it"));
}

TEST(CiePlan, NodesOfOneGroupShareAThread) {
  std::string app = kRobot;
  app.replace(app.find("/mapper, timer: 100ms"), std::string("/mapper, timer: 100ms").size(),
              "/perception/detector, timer: 100ms");
  const std::string shared = "/perception/detector@Subscription(/image)@Timer(100000000)";
  const std::string groups = "callback_groups:\n  - { id: /camera@Timer(33000000) }\n  - { id: " + shared +
                             " }\n  - { id: /planner@Subscription(/people) }\n";
  const Outcome outcome = threads_of("--cores 2" + with_template(groups), app);
  const Value root = read(outcome);
  EXPECT_EQ(text_of(group(root, shared), "affinity"), "0,1") << "a core of each";
  EXPECT_THAT(outcome.err, HasSubstr("2 nodes are callbacks of one group"));
}

TEST(CiePlan, WhatIsWrongIsSaid) {
  const auto refused = [](const Outcome& outcome, const std::string& said) {
    EXPECT_EQ(outcome.exit_code, 2) << said;
    EXPECT_EQ(outcome.out, "") << said;
    EXPECT_THAT(outcome.err, HasSubstr(said));
  };
  std::string missing = kTemplate;
  missing.replace(missing.find("/people"), 7, "/things");
  missing.replace(missing.find("/image"), 6, "/video");
  const Outcome none = threads_of("--cores 1" + with_template(missing));
  refused(none, "nodes.detect.ros: no callback group of ");
  EXPECT_THAT(none.err, HasSubstr("nodes.plan.ros: no callback group of ")) << "all of them at once";
  refused(threads_of("--cores 1" + with_template(std::string(kTemplate) + "  - { policy: SCHED_OTHER }\n")),
          "the id is missing");
  refused(threads_of("--cores 1" + with_template("hardware_info: {}\n")), "callback_groups: it is missing");
  refused(threads_of("--cores 1" + with_template("callback_groups: all\n")), "a list belongs here");
  refused(threads_of("--cores 1 --template nowhere.yaml"), "nowhere.yaml");
  refused(threads_of("--cores 2 --cpus 1"), "--cpus has 1 CPUs, and the plan 2 cores");
  refused(threads_of("--cores 1 --planner davare"), "--format cie is of plans with fixed priorities by auto");
  refused(threads_of("--cores 1", std::string(kRobot) + "scheduler: { schedule: frames }\n"), "schedule: frames");
  refused(threads_of("--cores 1 --json"), "--format");
  refused(run_catan("plan minimal.yaml --format cie", std::string(CATAN_TESTS) + "/apps"),
          "no node of app minimal is a callback of a ROS program");
}

TEST(CiePlan, ACallbackInTwoGroupsIsAmbiguous) {
  std::string groups = kTemplate;
  groups.insert(groups.find("  - id: /planner"), "  - id: /mapper@Timer(100000000)\n");
  const Outcome outcome = threads_of("--cores 1" + with_template(groups));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("several callback groups of "));
  EXPECT_THAT(outcome.err, HasSubstr("give timers of one node periods that differ"));
}

}  // namespace
}  // namespace ctn::test
