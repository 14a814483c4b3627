// Whether what is written is an app that Catan reads is tested where the command is.
#include "common/inferred_app.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace catan_ros {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kRuns = 20;

struct Runs {
  nanoseconds every = 100ms;
  nanoseconds cpu_time = 2ms;
  std::string from{};
  std::vector<std::string> published{};
  std::int64_t thread = 1;
};

std::vector<ObservedRun> runs_of(const Runs& what) {
  std::vector<ObservedRun> runs;
  for (int run = 0; run < kRuns; ++run) {
    runs.push_back({what.thread, 1s + run * what.every, what.cpu_time, what.from, what.published});
  }
  return runs;
}

ObservedCallback topic(const std::string& ros_node, const std::string& name, const Runs& runs) {
  ObservedCallback callback;
  callback.ros_node = ros_node;
  callback.name = name;
  callback.type = "std_msgs/Int64";
  callback.runs = runs_of(runs);
  return callback;
}

ObservedCallback timer(const std::string& ros_node, nanoseconds period, const Runs& runs) {
  ObservedCallback callback;
  callback.ros_node = ros_node;
  callback.kind = Binding::Kind::kTimer;
  callback.period = period;
  callback.runs = runs_of(runs);
  return callback;
}

ObservedCallback camera() { return timer("/camera", 20ms, {.every = 20ms, .cpu_time = 1ms, .published = {"/images"}}); }

ObservedCallback detector() {
  return topic("/detector", "/images", {.every = 40ms, .cpu_time = 30ms, .from = "/camera", .published = {"/things"}});
}

TEST(InferApp, ARowOfNodesIsASubchain) {
  const InferredApp inferred = infer_app(
      {camera(), detector(), topic("/follower", "/things", {.every = 40ms, .from = "/detector"})}, {}, "robot");
  EXPECT_EQ(inferred.app,
            "# Written by catan ros bind, from what running programs did. Check it, set the weights, then plan.\n"
            "catan: 1\n"
            "app: robot\n"
            "nodes:\n"
            "  camera: { fallback_rate: 50Hz, max_rate: 50Hz, ros: { node: /camera, timer: 20ms } }   # 20 runs\n"
            "  detector: { ros: { node: /detector, topic: /images } }   # std_msgs/Int64, 20 runs\n"
            "  follower: { ros: { node: /follower, topic: /things } }   # std_msgs/Int64, 20 runs\n"
            "edges:\n"
            "  - camera -> detector   # /images\n"
            "  - detector -> follower   # /things\n"
            "subchains:   # run at one rate, each node triggering the next\n"
            "  camera_to_follower: [camera, detector, follower]\n"
            "objective:   # the weights are yours to set: what a millisecond of each counts; remove what does not "
            "matter\n"
            "  - { response_time: [camera, detector, follower], weight: 1 }\n");
  EXPECT_EQ(inferred.costs,
            "# Written by catan ros bind: CPU time of a run, 95 % and half of the runs below it.\n"
            "camera: { cost: 1ms, typical: 1ms }\n"
            "detector: { cost: 30ms, typical: 30ms }\n"
            "follower: { cost: 2ms, typical: 2ms }\n");
  EXPECT_THAT(inferred.remarks, IsEmpty());
  EXPECT_EQ(inferred.nodes, 3U);
}

TEST(InferApp, WhatIsNotObservedIsExternal) {
  const Connections connections{{{"/scan", {"/laser"}}}, {{"/cmd_vel", {"/base"}}, {"/log", {"/rosbag"}}}};
  const InferredApp inferred = infer_app(
      {topic("/planner", "/scan", {.every = 50ms, .from = "/laser", .published = {"/cmd_vel"}})}, connections, "robot");
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("  scan: { external: true, period: 50ms }   # /scan of /laser\n"),
                                  HasSubstr("  planner: { fallback_rate: 20Hz, max_rate: 22Hz, ros:"),
                                  HasSubstr("  cmd_vel: { external: true }   # /cmd_vel of /base\n"),
                                  HasSubstr("  - scan -> planner   # /scan\n  - planner -> cmd_vel   # /cmd_vel\n"),
                                  HasSubstr("response_time: [scan, planner, cmd_vel]")));
  EXPECT_THAT(inferred.costs, AllOf(HasSubstr("planner: "), Not(HasSubstr("scan")), Not(HasSubstr("cmd_vel"))));
}

TEST(InferApp, WhatComesIrregularlyHasNoClock) {
  ObservedCallback planner = topic("/planner", "/goal", {.from = "/operator"});
  for (std::size_t run = 0; run < planner.runs.size(); run += 2) planner.runs[run].begin += 60ms;
  EXPECT_THAT(infer_app({planner}, {}, "robot").app, HasSubstr("  goal: { external: true }   # /goal of /operator\n"));
}

// A driver that publishes in its main loop, not in a callback.
TEST(InferApp, WhatAnObservedProgramPublishesOutsideOfCallbacksIsExternal) {
  const InferredApp inferred = infer_app(
      {topic("/driver", "/config", {.from = "/panel"}), topic("/mapper", "/scan", {.from = "/driver"})}, {}, "robot");
  EXPECT_THAT(inferred.app, HasSubstr("  - scan -> mapper   # /scan\n"));
}

TEST(InferApp, ALightCallbackThatPublishesNothingOnlyKeepsWhatItGets) {
  const InferredApp inferred = infer_app({topic("/planner", "/pose", {.cpu_time = 10us, .from = "/localiser"}),
                                          timer("/planner", 100ms, {.published = {"/cmd_vel"}}),
                                          timer("/localiser", 50ms, {.every = 50ms, .published = {"/pose"}})},
                                         {}, "robot");
  EXPECT_EQ(inferred.nodes, 2U);
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("  - localiser -> planner   # /pose, assumed: kept until it runs\n"),
                                  Not(HasSubstr("subchains")), HasSubstr("response_time: [localiser, planner]")));
}

TEST(InferApp, AHeavyCallbackThatPublishesNothingIsANode) {
  const InferredApp inferred = infer_app({topic("/slam", "/scan", {.cpu_time = 40ms, .from = "/laser"}),
                                          timer("/slam", 1s, {.every = 1s, .published = {"/map"}})},
                                         {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(HasSubstr("  - scan -> slam.scan   # /scan\n"),
                    HasSubstr("  - slam.scan -> slam.timer_1000ms   # within /slam, assumed: kept until it runs\n"),
                    HasSubstr("  slam: [slam.scan, slam.timer_1000ms]\n")));
}

TEST(InferApp, EdgesFormNoCycle) {
  // The simulator keeps the command until its timer; the controller answers each pose.
  const InferredApp inferred =
      infer_app({timer("/simulator", 10ms, {.every = 10ms, .published = {"/pose"}}),
                 topic("/simulator", "/cmd_vel", {.cpu_time = 10us, .from = "/controller"}),
                 topic("/controller", "/pose", {.every = 10ms, .from = "/simulator", .published = {"/cmd_vel"}})},
                {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(HasSubstr("  - simulator -> controller   # /pose\n"), Not(HasSubstr("- controller ->"))));
  EXPECT_THAT(inferred.remarks, ElementsAre("the edge controller -> simulator (/cmd_vel) is left out: it would close a "
                                            "cycle"));
}

TEST(InferApp, ANodeThatTwoFeedOrThatFeedsTwoIsNotInARow) {
  const InferredApp inferred =
      infer_app({camera(), detector(), topic("/viewer", "/images", {.every = 40ms, .from = "/camera"})}, {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(Not(HasSubstr("subchains")), HasSubstr("detector: { fallback_rate: 25Hz"),
                    HasSubstr("response_time: [camera, detector]"), HasSubstr("response_time: [camera, viewer]")));
}

TEST(InferApp, ANodeThatSeldomAnswersIsNotTriggeredByIt) {
  ObservedCallback seldom = detector();
  for (std::size_t run = 0; run < seldom.runs.size(); run += 2) seldom.runs[run].published.clear();
  const InferredApp inferred =
      infer_app({camera(), seldom, topic("/follower", "/things", {.every = 80ms, .from = "/detector"})}, {}, "robot");
  EXPECT_THAT(inferred.app, HasSubstr("  camera_to_detector: [camera, detector]\n"));
}

TEST(InferApp, WhatIsLeftOutIsTold) {
  ObservedCallback service = topic("/slam", "/slam/save", {});
  service.kind = Binding::Kind::kService;
  ObservedCallback idle = topic("/slam", "/reset", {});
  idle.runs.clear();
  const ObservedCallback watchdog = timer("/slam", 1s, {.every = 1s, .cpu_time = 10us});
  ObservedCallback anew = camera();
  for (ObservedRun& run : anew.runs) run.begin += 1s;
  const InferredApp inferred = infer_app(
      {camera(), anew, service, idle, watchdog, topic("/slam", "/tf", {}), topic("/slam", "/clock", {})}, {}, "robot");
  EXPECT_EQ(inferred.nodes, 1U);
  EXPECT_THAT(inferred.remarks,
              ElementsAre("/camera's timer of 20ms is there more than once; the first is the node",
                          "/slam's service /slam/save is left as it is; bind it if it matters",
                          "/slam's subscription of /reset was not called",
                          "/slam's timer of 1000ms publishes nothing and takes next to no time: it is left as it is"));
  EXPECT_THAT(inferred.app, HasSubstr("# - /slam's subscription of /reset was not called\n"));
  EXPECT_THAT(inferred.app, HasSubstr("  - { period: camera, weight: 1 }\n"));
}

// A manager of nodelets: a camera, and two that take its images, of which one goes on to a tracker.
std::vector<ObservedCallback> nodelets() {
  const auto alive = [](const std::string& ros_node) {
    return timer(ros_node, 1s, {.every = 1s, .cpu_time = 20us, .published = {"/manager/bond"}});
  };
  ObservedCallback lives = topic("/manager", "/manager/bond", {.every = 500ms, .cpu_time = 20us, .from = "/rectify"});
  lives.type = "bond/Status";
  return {lives,
          alive("/manager"),
          alive("/rectify"),
          timer("/manager", 20ms, {.every = 20ms, .cpu_time = 1ms, .published = {"/images"}}),
          topic("/manager", "/images", {.every = 20ms, .from = "/manager", .published = {"/rectified"}}),
          topic("/manager", "/images", {.every = 40ms, .cpu_time = 30ms, .from = "/manager", .published = {"/large"}}),
          topic("/manager", "/rectified", {.every = 20ms, .from = "/manager", .published = {"/tracks"}})};
}

TEST(InferApp, SignsOfLifeOfNodeletsAreNoData) {
  const InferredApp inferred = infer_app(nodelets(), {}, "robot");
  EXPECT_THAT(inferred.app, Not(HasSubstr("/manager/bond")));
  EXPECT_THAT(inferred.remarks,
              Contains("/rectify's timer of 1000ms publishes nothing and takes next to no time: it is left as it is"));
  EXPECT_THAT(inferred.remarks, Not(Contains(HasSubstr("cycle"))));
}

TEST(InferApp, CallbacksThatCannotBeToldApartAreLeftAsTheyAre) {
  const InferredApp inferred = infer_app(nodelets(), {}, "robot");
  EXPECT_EQ(inferred.nodes, 2U);
  EXPECT_THAT(
      inferred.remarks,
      Contains("/manager's subscription of /images is there 2 times, and which is which cannot be told: all are "
               "left as they are; in programs of their own they can be nodes"));
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("timer: 20ms"), HasSubstr("  - rectified -> manager.rectified"),
                                  Not(HasSubstr("topic: /images"))));
}

// A binding names the first of them all.
TEST(InferApp, OfCallbacksThatCannotBeToldApartNoneIsANodeAlsoLaterOnes) {
  std::vector<ObservedCallback> callbacks = nodelets();
  ObservedCallback anew = callbacks[5];
  for (ObservedRun& run : anew.runs) run.begin += 1min;
  callbacks.push_back(anew);
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_EQ(inferred.nodes, 2U);
  EXPECT_THAT(inferred.remarks, Contains(HasSubstr("subscription of /images is there 3 times, and which is which")));
  EXPECT_THAT(inferred.app, Not(HasSubstr("topic: /images")));
}

// The camera's timer publishes, but what comes of its images is nothing that it uses.
TEST(InferApp, WhatIsKeptIsNotForThoseItComesFrom) {
  std::vector<ObservedCallback> callbacks = nodelets();
  callbacks.push_back(topic("/manager", "/rectified/info", {.every = 20ms, .cpu_time = 10us, .from = "/manager"}));
  callbacks[4].runs = runs_of({.every = 20ms, .from = "/manager", .published = {"/rectified", "/rectified/info"}});
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app, Not(HasSubstr("-> manager.timer_20ms")));
  EXPECT_THAT(inferred.app, HasSubstr("rectified/info -> manager.rectified"));
}

ObservedCallback of_nodelet(const std::string& nodelet, ObservedCallback callback) {
  callback.nodelet = nodelet;
  callback.one_at_a_time = true;
  return callback;
}

// The same manager's, where it is known whose callback is whose.
std::vector<ObservedCallback> nodelets_told_apart() {
  std::vector<ObservedCallback> callbacks = nodelets();
  const std::vector<std::string> names{"", "", "", "/camera", "/rectify", "/large", "/track"};
  for (std::size_t index = 3; index < callbacks.size(); ++index) {
    callbacks[index] = of_nodelet(names[index], callbacks[index]);
  }
  return callbacks;
}

TEST(InferApp, NodeletsOfOneManagerAreProgramsOfTheirOwn) {
  const InferredApp inferred = infer_app(nodelets_told_apart(), {}, "robot");
  EXPECT_EQ(inferred.nodes, 4U);
  EXPECT_THAT(
      inferred.app,
      AllOf(HasSubstr("  camera: { fallback_rate: 50Hz, max_rate: 50Hz, "
                      "ros: { node: /manager, nodelet: /camera, timer: 20ms } }   # 20 runs\n"),
            HasSubstr("ros: { node: /manager, nodelet: /rectify, topic: /images } }   # std_msgs/Int64, 20 runs\n"),
            HasSubstr("ros: { node: /manager, nodelet: /large, topic: /images } }"),
            HasSubstr("  - camera -> large   # /images\n"), HasSubstr("  - rectify -> track   # /rectified\n"),
            HasSubstr("response_time: [camera, rectify, track]")));
  EXPECT_THAT(inferred.app, Not(HasSubstr("exclusive"))) << "one thread has called all, but their queues are apart";
  EXPECT_THAT(inferred.remarks, Not(Contains(HasSubstr("cannot be told"))));
}

TEST(InferApp, CallbacksOfOneNodeletAreNotToldApart) {
  std::vector<ObservedCallback> callbacks = nodelets_told_apart();
  callbacks[5].nodelet = "/rectify";
  EXPECT_THAT(
      infer_app(callbacks, {}, "robot").remarks,
      Contains("nodelet /rectify's subscription of /images is there 2 times, and which is which cannot be told: "
               "all are left as they are; in programs of their own they can be nodes"));
}

TEST(InferApp, WhatANodeletKeepsItUsesItself) {
  std::vector<ObservedCallback> callbacks = nodelets_told_apart();
  callbacks.push_back(of_nodelet("/large", topic("/manager", "/pose", {.cpu_time = 10us, .from = "/localiser"})));
  EXPECT_THAT(infer_app(callbacks, {}, "robot").app,
              AllOf(HasSubstr("  - pose -> large   # /pose, assumed: kept until it runs\n"),
                    Not(HasSubstr("pose -> rectify")), Not(HasSubstr("pose -> track"))));
}

TEST(InferApp, CallbacksOfANodeletsQueueNeverOverlap) {
  const ObservedCallback image = of_nodelet("/proc", topic("/manager", "/images", {.published = {"/rectified"}}));
  ObservedCallback info = of_nodelet("/proc", topic("/manager", "/info", {.thread = 2}));
  const auto app = [&] { return infer_app({image, info}, {}, "robot").app; };
  EXPECT_THAT(app(), AllOf(HasSubstr("  proc.images: {"), HasSubstr("  proc.info: {"),
                           HasSubstr("exclusive:   # callbacks of one spinner or nodelet: their runs never overlap\n"),
                           HasSubstr("  proc: [proc.info, proc.images]\n")));
  info.one_at_a_time = false;
  EXPECT_THAT(app(), Not(HasSubstr("exclusive"))) << "of its other queue";
}

TEST(InferApp, NamesAreUniqueAndPeriodsExact) {
  const InferredApp inferred = infer_app(
      {timer("/scan", 33'333'333ns, {.published = {"/robot/scan"}}), topic("/robot/slam", "/scan", {.from = "/laser"})},
      {}, "robot");
  EXPECT_THAT(
      inferred.app,
      AllOf(HasSubstr("  scan: { fallback_rate: 30Hz, max_rate: 30Hz, ros: { node: /scan, timer: 33333333ns } }"),
            HasSubstr("  scan_2: { external: true, period: 100ms }"), HasSubstr("  slam: {")));
}

TEST(InferApp, NamespacesAreLeftOutWhereNamesDifferWithoutThem) {
  const std::string app =
      infer_app({timer("/left/camera", 20ms, {.every = 20ms}), timer("/right/camera", 20ms, {.every = 20ms}),
                 timer("/left/rectify", 20ms, {.every = 20ms})},
                {}, "robot")
          .app;
  EXPECT_THAT(app, AllOf(HasSubstr("\n  left/camera: {"), HasSubstr("\n  right/camera: {"), HasSubstr("\n  rectify: {"),
                         HasSubstr("ros: { node: /left/rectify, timer: 20ms }")));
}

// Runs from `first` on publish as well.
ObservedCallback completing(ObservedCallback callback, std::size_t first, const std::string& published) {
  for (std::size_t run = first; run < callback.runs.size(); ++run) callback.runs[run].published = {published};
  return callback;
}

// image_proc: an image and its camera_info have one stamp, and are used together. Where each was a node that takes the
// newest, messages of equal stamps would be passed over.
TEST(InferApp, OfMessagesThatAreUsedTogetherTheLastIsTheNode) {
  const ObservedCallback info =
      completing(topic("/proc", "/info", {.cpu_time = 20us, .from = "/camera"}), kRuns - 2, "/rectified");
  ObservedCallback image = topic("/proc", "/images", {.from = "/camera", .published = {"/rectified"}});
  for (std::size_t run = kRuns - 2; run < image.runs.size(); ++run) image.runs[run].published.clear();
  const ObservedCallback camera = timer("/camera", 100ms, {.cpu_time = 1ms, .published = {"/images", "/info"}});
  const InferredApp inferred =
      infer_app({camera, info, image, topic("/shown", "/rectified", {.from = "/proc"})}, {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(HasSubstr("  proc: { ros: { node: /proc, topic: /images } }"), Not(HasSubstr("topic: /info }")),
                    HasSubstr("  - proc -> shown   # /rectified\n"), HasSubstr("[camera, proc, shown]")));
  EXPECT_THAT(inferred.remarks, ElementsAre("/proc's subscription of /info is left as it is: its messages are used "
                                            "with those of /images, which come last"));
}

// What comes by way of another callback comes last under Catan, however quick that was while it was observed.
TEST(InferApp, OfMessagesThatAreUsedTogetherTheOneFurthestFromTheSourceIsTheNode) {
  const ObservedCallback info =
      topic("/proc", "/info", {.cpu_time = 20us, .from = "/camera", .published = {"/rectified"}});
  const ObservedCallback mono = completing(topic("/proc", "/mono", {.from = "/proc"}), kRuns - 1, "/rectified");
  const ObservedCallback camera = timer("/camera", 100ms, {.cpu_time = 1ms, .published = {"/images", "/info"}});
  const ObservedCallback image = topic("/proc", "/images", {.from = "/camera", .published = {"/mono"}});
  EXPECT_THAT(infer_app({camera, info, image, mono}, {}, "robot").app,
              AllOf(HasSubstr("topic: /mono }"), Not(HasSubstr("topic: /info }")),
                    HasSubstr("[camera, proc.images, proc.mono]")));
}

TEST(InferApp, WhereAnyMessageMayComeLastNoneIsPassedOver) {
  const ObservedCallback left = completing(topic("/stereo", "/left", {.from = "/camera"}), kRuns / 2, "/depth");
  ObservedCallback right = topic("/stereo", "/right", {.from = "/camera", .published = {"/depth"}});
  for (std::size_t run = kRuns / 2; run < right.runs.size(); ++run) right.runs[run].published.clear();
  EXPECT_THAT(infer_app({left, right}, {}, "robot").app,
              AllOf(HasSubstr("  stereo.left: { input: queue, "), HasSubstr("  stereo.right: { input: queue, ")));
}

// Of two rows of callbacks neither is behind the other, however long they are.
TEST(InferApp, WhereMessagesComeFromApartNeitherIsLast) {
  const ObservedCallback left = completing(topic("/fuse", "/left", {.from = "/left"}), kRuns / 2, "/fused");
  ObservedCallback right = topic("/fuse", "/right", {.from = "/right", .published = {"/fused"}});
  for (std::size_t run = kRuns / 2; run < right.runs.size(); ++run) right.runs[run].published.clear();
  EXPECT_THAT(infer_app({timer("/camera", 100ms, {.published = {"/images"}}),
                         topic("/left", "/images", {.from = "/camera", .published = {"/left"}}),
                         timer("/right", 100ms, {.published = {"/right"}}), left, right},
                        {}, "robot")
                  .app,
              AllOf(HasSubstr("  fuse.left: { input: queue, "), HasSubstr("  fuse.right: { input: queue, ")));
}

// Of the camera, an image and its info: in one callback, or by a nodelet for each in between.
struct RotatedImages {
  ObservedCallback camera = of_nodelet("/camera", timer("/manager", 100ms, {.published = {"/images", "/info"}}));
  // Turns an image when its info has come, which was always last.
  ObservedCallback image = of_nodelet("/rotate", topic("/manager", "/images", {.cpu_time = 10us, .from = "/manager"}));
  ObservedCallback info =
      of_nodelet("/rotate", topic("/manager", "/info", {.from = "/manager", .published = {"/rotated"}}));
  ObservedCallback shown = of_nodelet("/shown", topic("/manager", "/rotated", {.from = "/manager"}));

  std::vector<ObservedCallback> all() const { return {camera, image, info, shown}; }
  std::string app() const { return infer_app(all(), {}, "robot").app; }
};

TEST(InferApp, WhatOneSendsComesInItsOrder) {
  const RotatedImages rotated;
  const InferredApp inferred = infer_app(rotated.all(), {}, "robot");
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("  rotate: { ros: { node: /manager, nodelet: /rotate, topic: /info } }"),
                                  HasSubstr("  - camera -> rotate   # /info\n"), Not(HasSubstr("queue")),
                                  Not(HasSubstr("topic: /images }"))));
  EXPECT_THAT(inferred.remarks, ElementsAre("nodelet /rotate's subscription of /images is left as it is: its messages "
                                            "are used with those of /info, which come last"));
}

// As Debian's image pipeline has them: one callback scales the image, another its info.
TEST(InferApp, WhereTwoSendAnyMessageMayComeLast) {
  RotatedImages rotated;
  rotated.image.name = "/scaled/images";
  rotated.info.name = "/scaled/info";
  std::vector<ObservedCallback> callbacks = rotated.all();
  callbacks.push_back(of_nodelet(
      "/scale", topic("/manager", "/images", {.cpu_time = 8ms, .from = "/manager", .published = {"/scaled/images"}})));
  callbacks.push_back(
      of_nodelet("/scale", topic("/manager", "/info", {.from = "/manager", .published = {"/scaled/info"}})));
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(HasSubstr("  rotate.images: { input: queue, "), HasSubstr("  rotate.info: { input: queue, "),
                    HasSubstr("  - scale.images -> rotate.images   # /scaled/images\n"),
                    HasSubstr("  - scale.info -> rotate.info   # /scaled/info\n"),
                    HasSubstr("  - rotate.images -> shown   # /rotated\n"),
                    HasSubstr("  - rotate.info -> shown   # /rotated\n"), Not(HasSubstr("kept until it runs"))));
  EXPECT_THAT(inferred.app, HasSubstr("max_rate: 11Hz, ros: { node: /manager, nodelet: /shown,"))
      << "one of the two completes each set";
  EXPECT_THAT(inferred.remarks, IsEmpty());
}

// Which one was last is as much chance where it was the other once, or twice.
TEST(InferApp, WhereTwoSendItDoesNotMatterThatOneMostlyCameLast) {
  RotatedImages rotated;
  rotated.image.name = "/scaled/images";
  rotated.info.name = "/scaled/info";
  rotated.image.runs.back().published = {"/rotated"};
  rotated.info.runs.back().published.clear();
  const std::vector<ObservedCallback> senders{
      of_nodelet("/scale", topic("/manager", "/images", {.from = "/manager", .published = {"/scaled/images"}})),
      of_nodelet("/scale", topic("/manager", "/info", {.from = "/manager", .published = {"/scaled/info"}}))};
  std::vector<ObservedCallback> callbacks = rotated.all();
  callbacks.insert(callbacks.end(), senders.begin(), senders.end());
  EXPECT_THAT(infer_app(callbacks, {}, "robot").app,
              AllOf(HasSubstr("  rotate.images: { input: queue, "), HasSubstr("  rotate.info: { input: queue, ")));
  rotated.image.name = "/images";
  rotated.info.name = "/info";
  EXPECT_THAT(rotated.app(), AllOf(HasSubstr("nodelet: /rotate, topic: /info } }"), Not(HasSubstr("queue"))))
      << "one sends both";
}

// The scaled image comes by way of another callback, the info from the camera itself.
TEST(InferApp, TheOneBehindTheOthersIsTheNodeThoughItNeverCameLast) {
  RotatedImages rotated;
  rotated.image.name = "/scaled/images";
  std::vector<ObservedCallback> callbacks = rotated.all();
  callbacks.push_back(of_nodelet(
      "/scale", topic("/manager", "/images", {.cpu_time = 8ms, .from = "/manager", .published = {"/scaled/images"}})));
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("nodelet: /rotate, topic: /scaled/images } }"),
                                  Not(HasSubstr("topic: /info")), HasSubstr("  - rotate -> shown   # /rotated\n")));
  EXPECT_THAT(inferred.remarks,
              ElementsAre("nodelet /rotate's subscription of /info is left as it is: its messages are "
                          "used with those of /scaled/images, which come last"));
}

ObservedCallback publishing_in(ObservedCallback callback, std::size_t first, std::size_t last,
                               const std::string& published) {
  for (std::size_t run = 0; run < callback.runs.size(); ++run) {
    callback.runs[run].published.clear();
    if (run >= first && run < last) callback.runs[run].published.push_back(published);
  }
  return callback;
}

// Else what they publish would be all of a set's, and the one that can be a node be left as it is with them.
TEST(InferApp, CallbacksThatCannotBeToldApartCompleteNoSets) {
  const ObservedCallback image = topic("/proc", "/images", {.from = "/camera"});
  const ObservedCallback info = topic("/proc", "/info", {.from = "/camera"});
  const InferredApp inferred =
      infer_app({camera(), publishing_in(image, 0, kRuns - 3, "/rectified"), publishing_in(image, 0, 1, "/rectified"),
                 publishing_in(info, kRuns - 2, kRuns, "/rectified")},
                {}, "robot");
  EXPECT_EQ(inferred.nodes, 2U);
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("topic: /info }"), Not(HasSubstr("topic: /images }"))));
  EXPECT_THAT(inferred.remarks, ElementsAre(HasSubstr("subscription of /images is there 2 times")));
}

// What they keep is as much part of a set, but none of them is the node that completes it.
TEST(InferApp, CallbacksThatCannotBeToldApartAreNotBehindAllOthers) {
  RotatedImages rotated;
  rotated.image.name = "/scaled/images";
  ObservedCallback alike = rotated.image;
  alike.runs = runs_of({.cpu_time = 20ms, .from = "/manager", .published = {"/seen"}});
  std::vector<ObservedCallback> callbacks = rotated.all();
  callbacks.push_back(alike);
  callbacks.push_back(of_nodelet(
      "/scale", topic("/manager", "/images", {.cpu_time = 8ms, .from = "/manager", .published = {"/scaled/images"}})));
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("  rotate: { input: queue, "), HasSubstr("topic: /info } }"),
                                  HasSubstr("  - rotate -> shown   # /rotated\n")));
  EXPECT_THAT(inferred.remarks, ElementsAre(HasSubstr("subscription of /scaled/images is there 2 times")));
}

// The same callbacks once more when the others' runs have ended.
std::vector<ObservedCallback> subscribed_again(std::vector<ObservedCallback> callbacks) {
  const std::size_t once = callbacks.size();
  for (std::size_t index = 0; index < once; ++index) {
    callbacks.push_back(callbacks[index]);
    for (ObservedRun& run : callbacks.back().runs) run.begin += 1min;
  }
  return callbacks;
}

TEST(InferApp, AProgramThatSubscribedAgainCompletesTheSetsThatItDid) {
  const ObservedCallback image = topic("/proc", "/images", {.from = "/camera"});
  const ObservedCallback info = topic("/proc", "/info", {.from = "/camera"});
  std::vector<ObservedCallback> callbacks = subscribed_again(
      {publishing_in(info, kRuns - 2, kRuns, "/rectified"), publishing_in(image, 0, kRuns - 2, "/rectified")});
  callbacks.push_back(timer("/camera", 100ms, {.published = {"/images", "/info"}}));
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app, AllOf(HasSubstr("topic: /images }"), Not(HasSubstr("topic: /info }"))));
  EXPECT_THAT(inferred.remarks, Contains("/proc's subscription of /info is left as it is: its messages are used with "
                                         "those of /images, which come last"));
}

// It is the node, under the name of the first, and keeps nothing for others.
TEST(InferApp, OneThatTookThePlaceOfAnotherKeepsNothing) {
  std::vector<ObservedCallback> callbacks = subscribed_again({detector()});
  callbacks.push_back(camera());
  callbacks.push_back(timer("/detector", 1s, {.every = 1s, .published = {"/status"}}));
  const InferredApp inferred = infer_app(callbacks, {}, "robot");
  EXPECT_THAT(inferred.app,
              AllOf(HasSubstr("  - camera -> detector.images   # /images\n"), Not(HasSubstr("kept until it runs"))));
}

TEST(InferApp, WhatIsNotCalledByTurnsIsNoSet) {
  RotatedImages rotated;
  rotated.image.runs = runs_of({.every = 50ms, .cpu_time = 10us, .from = "/manager"});
  EXPECT_THAT(rotated.app(), AllOf(HasSubstr("  - camera -> rotate   # /info\n"), Not(HasSubstr("queue"))));
  EXPECT_THAT(infer_app(rotated.all(), {}, "robot").remarks, IsEmpty());
}

// For a while the program had two connections, and each image came twice.
TEST(InferApp, AMessageThatCameTwiceTakesNoTurnFromTheOther) {
  RotatedImages rotated;
  const std::vector<ObservedRun> once = rotated.image.runs;
  for (std::size_t run = 0; run < once.size() / 2; ++run) {
    rotated.image.runs.push_back(once[run]);
    rotated.image.runs.back().begin += 2ms;
  }
  const auto begins_earlier = [](const ObservedRun& a, const ObservedRun& b) { return a.begin < b.begin; };
  std::sort(rotated.image.runs.begin(), rotated.image.runs.end(), begins_earlier);
  EXPECT_THAT(infer_app(rotated.all(), {}, "robot").remarks, Contains(HasSubstr("are used with those of /info")));
}

// It gets what comes of what the other sends: no set can have both.
TEST(InferApp, WhatComesOfTheOthersOutputIsNoSetWithIt) {
  RotatedImages rotated;
  rotated.image.name = "/results";
  rotated.shown = of_nodelet("/shown", topic("/manager", "/rotated", {.from = "/manager", .published = {"/results"}}));
  const InferredApp inferred = infer_app(rotated.all(), {}, "robot");
  EXPECT_THAT(inferred.app, AllOf(Not(HasSubstr("queue")), Not(HasSubstr("topic: /results"))));
  EXPECT_THAT(inferred.remarks, Not(Contains(HasSubstr("which come last"))));
}

// A program that is no nodelet keeps what it gets for any reason.
TEST(InferApp, WithoutNodeletsWhatIsKeptIsNoSet) {
  RotatedImages rotated;
  rotated.image.nodelet.clear();
  rotated.info.nodelet.clear();
  EXPECT_THAT(infer_app(rotated.all(), {}, "robot").remarks, IsEmpty());
  EXPECT_THAT(rotated.app(), Not(HasSubstr("queue")));
}

// A multiplexer passes on what comes, whoever sends it.
TEST(InferApp, CallbacksThatPublishEachForItselfAreNodes) {
  const Runs sent{.from = "/operator", .published = {"/cmd_vel"}};
  EXPECT_THAT(infer_app({topic("/mux", "/joystick", sent), topic("/mux", "/planner", sent)}, {}, "robot").app,
              AllOf(HasSubstr("topic: /joystick }"), HasSubstr("topic: /planner }"), Not(HasSubstr("queue"))));
}

// A node that waits for its messages is not planned to run more often than they come.
TEST(InferApp, RatesAreBoundedByWhatComes) {
  const auto app = [](const std::vector<ObservedCallback>& callbacks) { return infer_app(callbacks, {}, "robot").app; };
  const ObservedCallback two = topic("/fuse", "/things", {.from = "/a", .published = {"/fused"}});
  const std::vector<ObservedCallback> senders{
      timer("/a", 50ms, {.every = 50ms, .published = {"/things"}}), timer("/b", 100ms, {.published = {"/things"}}), two,
      topic("/shown", "/fused", {.from = "/fuse"}), topic("/log", "/fused", {.from = "/fuse"})};
  EXPECT_THAT(app(senders),
              AllOf(HasSubstr("max_rate: 33Hz, ros: { node: /fuse,"), HasSubstr("max_rate: 33Hz, ros: { node: /shown,"),
                    HasSubstr("max_rate: 33Hz, ros: { node: /log,")));
  ObservedCallback goal = topic("/planner", "/goal", {.from = "/operator"});
  for (std::size_t run = 0; run < goal.runs.size(); run += 2) goal.runs[run].begin += 60ms;
  EXPECT_THAT(app({goal}), Not(HasSubstr("max_rate")));
}

TEST(InferApp, WithoutCallbacksThereIsNoApp) {
  const InferredApp inferred = infer_app({}, {}, "robot");
  EXPECT_EQ(inferred.nodes, 0U);
  EXPECT_EQ(inferred.app, "");
}

}  // namespace
}  // namespace catan_ros
