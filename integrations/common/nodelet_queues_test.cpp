#include "common/nodelet_queues.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <thread>

namespace catan_ros {
namespace {

// Where queues lie; what they are does not matter.
constexpr std::array<int, NodeletQueues::kMaxQueues + 1> kPlaces{};
constexpr const void* kQueue = &kPlaces[0];
constexpr const void* kOther = &kPlaces[1];

// Whether a bound callback could run at this moment, in a thread of its own.
bool may_run(Turn& turn) {
  bool taken = false;
  std::thread([&] {
    // Stopped from the beginning: it tries once.
    const std::atomic<bool> stop{true};
    taken = turn.take(stop);
    if (taken) turn.give_back();
  }).join();
  return taken;
}

TEST(NodeletQueues, AreOfANodeletUntilTheyGo) {
  NodeletQueues queues;
  EXPECT_EQ(queues.nodelet_of(kQueue), "");
  queues.add(kQueue, true);
  queues.add(kOther, false);
  queues.set_nodelet(kQueue, "/turn");
  queues.set_nodelet(kOther, "/turn");
  EXPECT_EQ(queues.nodelet_of(kQueue), "/turn");
  EXPECT_EQ(queues.nodelet_of(kOther), "/turn");
  EXPECT_TRUE(queues.calls_one_at_a_time(kQueue));
  EXPECT_FALSE(queues.calls_one_at_a_time(kOther));
  queues.remove(kQueue);
  EXPECT_EQ(queues.nodelet_of(kQueue), "");
  EXPECT_FALSE(queues.calls_one_at_a_time(kQueue));
  EXPECT_EQ(queues.nodelet_of(kOther), "/turn");
}

TEST(NodeletQueues, AnotherAtTheSamePlaceIsAnothers) {
  NodeletQueues queues;
  queues.add(kQueue, true);
  queues.set_nodelet(kQueue, "/turn");
  queues.add(kQueue, false);
  EXPECT_EQ(queues.nodelet_of(kQueue), "");
  queues.set_nodelet(kQueue, "/scale");
  EXPECT_EQ(queues.nodelet_of(kQueue), "/scale");
  EXPECT_FALSE(queues.calls_one_at_a_time(kQueue));
}

TEST(NodeletQueues, ABoundCallbackNeedsNoWorker) {
  NodeletQueues queues;
  queues.add(kQueue, true);
  const std::unique_ptr<Turn> turn = queues.turn_of(kQueue);
  ASSERT_NE(turn, nullptr);
  EXPECT_TRUE(may_run(*turn)) << "none has called anything yet";
}

TEST(NodeletQueues, NothingRunsBesideAWorkersCall) {
  NodeletQueues queues;
  queues.add(kQueue, true);
  queues.add(kOther, true);
  const std::unique_ptr<Turn> turn = queues.turn_of(kQueue);
  const std::unique_ptr<Turn> others = queues.turn_of(kOther);
  void* const taken = queues.call(kQueue);
  EXPECT_NE(taken, nullptr);
  EXPECT_FALSE(may_run(*turn));
  EXPECT_TRUE(may_run(*others)) << "of another nodelet";
  NodeletQueues::called(taken);
  EXPECT_TRUE(may_run(*turn));
}

// One turn, however many workers there are.
TEST(NodeletQueues, CallbacksOfOneQueueNeverOverlap) {
  NodeletQueues queues;
  queues.add(kQueue, true);
  int inside = 0;
  int overlaps = 0;
  const auto callback = [&] {
    if (++inside != 1) ++overlaps;
    std::this_thread::yield();
    --inside;
  };
  const auto bound = [&] {
    const std::unique_ptr<Turn> turn = queues.turn_of(kQueue);
    const std::atomic<bool> stop{false};
    for (int run = 0; run < 300; ++run) {
      turn->take(stop);
      callback();
      turn->give_back();
    }
  };
  const auto worker = [&] {
    for (int call = 0; call < 300; ++call) {
      void* const taken = queues.call(kQueue);
      callback();
      NodeletQueues::called(taken);
    }
  };
  std::array<std::thread, 4> threads{std::thread(bound), std::thread(bound), std::thread(worker), std::thread(worker)};
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(overlaps, 0);
}

TEST(NodeletQueues, ThoseOfCallbacksSideBySideNeedNoTurn) {
  NodeletQueues queues;
  queues.add(kQueue, false);
  const std::unique_ptr<Turn> turn = queues.turn_of(kQueue);
  ASSERT_NE(turn, nullptr);
  EXPECT_EQ(queues.call(kQueue), nullptr);
  const std::atomic<bool> stop{false};
  EXPECT_TRUE(turn->take(stop));
  EXPECT_TRUE(may_run(*queues.turn_of(kQueue)));
  turn->give_back();
}

// A nodelet was unloaded and is loaded again: its callback is the same node, and the queue may be another's place.
TEST(NodeletQueues, ATurnIsOfTheQueueThatIsThereNow) {
  NodeletQueues queues;
  queues.add(kQueue, false);
  const std::unique_ptr<Turn> turn = queues.turn_of(kQueue);
  queues.remove(kQueue);
  queues.add(kQueue, true);
  void* const taken = queues.call(kQueue);
  EXPECT_NE(taken, nullptr);
  EXPECT_FALSE(may_run(*turn));
  NodeletQueues::called(taken);
  EXPECT_TRUE(may_run(*turn));
}

TEST(NodeletQueues, OfOthersNothingIsKnown) {
  NodeletQueues queues;
  EXPECT_EQ(queues.turn_of(kQueue), nullptr);
  EXPECT_EQ(queues.call(kQueue), nullptr);
  queues.set_nodelet(kQueue, "/turn");
  EXPECT_EQ(queues.turn_of(kQueue), nullptr) << "it was not told how its callbacks are called";
  for (std::size_t place = 1; place < kPlaces.size(); ++place) queues.add(&kPlaces[place], true);
  const void* const last = &kPlaces.back();
  EXPECT_EQ(queues.turn_of(last), nullptr) << "there are too many";
  EXPECT_EQ(queues.nodelet_of(last), "");
}

}  // namespace
}  // namespace catan_ros
