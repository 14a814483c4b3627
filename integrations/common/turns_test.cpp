#include "common/turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace catan_ros {
namespace {

const std::atomic<bool> kGoOn{false};

// Does it in a thread of its own, and waits for it.
void in_a_thread(const std::function<void()>& work) { std::thread(work).join(); }

// Whether a node's thread would get a turn at this moment; it gives it back.
bool is_free(Turns& turns) {
  bool taken = false;
  in_a_thread([&] {
    // Stopped from the beginning: it tries once.
    const std::atomic<bool> stop{true};
    taken = turns.take(stop);
    turns.give_back();
  });
  return taken;
}

TEST(Turns, ThereIsNoneBeforeTheQueueIsSpun) {
  Turns turns;
  EXPECT_FALSE(is_free(turns));
}

TEST(Turns, ASpinnerHasNoneOnlyWhileItWaits) {
  Turns turns;
  turns.enter();
  EXPECT_TRUE(is_free(turns));
  const bool taken = turns.begin();
  EXPECT_FALSE(is_free(turns)) << "in a callback";
  turns.end(taken);
  EXPECT_TRUE(is_free(turns));
  turns.leave();
  EXPECT_FALSE(is_free(turns)) << "between two calls of spinOnce()";
  turns.enter();
  EXPECT_TRUE(is_free(turns));
  turns.leave();
}

TEST(Turns, TwoSpinnersHaveTwo) {
  Turns turns;
  turns.enter();
  in_a_thread([&] {
    turns.enter();
    const bool taken = turns.begin();
    EXPECT_TRUE(is_free(turns)) << "of the other";
    turns.end(taken);
    turns.leave();
  });
  EXPECT_TRUE(is_free(turns));
  turns.leave();
  EXPECT_FALSE(is_free(turns));
}

TEST(Turns, ACallbackThatSpinsLetsOthersRun) {
  Turns turns;
  turns.enter();
  const bool taken = turns.begin();
  EXPECT_FALSE(is_free(turns));
  turns.enter();
  EXPECT_TRUE(is_free(turns));
  const bool inner = turns.begin();
  EXPECT_FALSE(is_free(turns));
  turns.end(inner);
  turns.leave();
  EXPECT_FALSE(is_free(turns)) << "the outer callback goes on";
  turns.end(taken);
  EXPECT_TRUE(is_free(turns));
  turns.leave();
}

TEST(Turns, OfAFixedNumberNobodyBringsMore) {
  Turns turns(1);
  EXPECT_TRUE(is_free(turns)) << "without a spinner";
  const bool taken = turns.begin();
  EXPECT_FALSE(is_free(turns));
  in_a_thread([&] {
    turns.enter();
    EXPECT_FALSE(is_free(turns));
  });
  turns.end(taken);
  EXPECT_TRUE(is_free(turns));
}

TEST(Turns, ASpinnerThatBeganBeforeThereWereAnyFits) {
  Turns turns;
  const bool taken = turns.begin();  // without enter()
  EXPECT_TRUE(taken);
  EXPECT_FALSE(is_free(turns));
  turns.end(taken);
  EXPECT_TRUE(is_free(turns));
  turns.leave();
  EXPECT_FALSE(is_free(turns));
}

TEST(Turns, ACallbackThatSubscribesIsNotInterrupted) {
  Turns turns;
  turns.leave();  // spinOnce() returns, in which the first bound callback came to be
  EXPECT_FALSE(is_free(turns));
  turns.enter();
  EXPECT_TRUE(is_free(turns));
  turns.leave();
}

// A program may start and stop its spinners as often as it likes.
TEST(Turns, ASpinnerThatEndsHoldsUpNoneThatComesAfterIt) {
  Turns turns;
  for (std::size_t spinner = 0; spinner < 2 * Turns::kMaxSpinners; ++spinner) {
    bool was_free = false;
    in_a_thread([&] {
      turns.enter();
      was_free = is_free(turns);
      if (was_free) turns.leave();  // which would wait for a turn
    });
    ASSERT_TRUE(was_free) << "spinner " << spinner;
  }
}

TEST(Turns, ASpinnerThatEndsTakesOneTurnAlong) {
  Turns turns;
  turns.enter();
  in_a_thread([&] {
    turns.enter();
    turns.leave();
  });
  in_a_thread([&] {
    ASSERT_TRUE(turns.take(kGoOn)) << "that of the spinner that goes on";
    EXPECT_FALSE(is_free(turns));
    turns.give_back();
  });
  EXPECT_TRUE(is_free(turns));
}

TEST(Turns, AThreadThatBroughtNoneEndsWithoutOne) {
  Turns turns(1);
  in_a_thread([&] { turns.begin(); });
  EXPECT_TRUE(is_free(turns)) << "it has not given it back";
  turns.enter();
  EXPECT_TRUE(is_free(turns)) << "there is one still";
}

// What one writes, another reads without a lock of its own: the turn is one.
TEST(Turns, CallbacksOfOneSpinnerNeverOverlap) {
  Turns turns;
  int inside = 0;
  int overlaps = 0;
  const auto callback = [&] {
    if (++inside != 1) ++overlaps;
    std::this_thread::yield();
    --inside;
  };
  turns.enter();  // the turn is there before the nodes' threads want it
  std::vector<std::thread> nodes;
  for (int node = 0; node < 3; ++node) {
    nodes.emplace_back([&] {
      for (int run = 0; run < 300; ++run) {
        turns.take(kGoOn);
        callback();
        turns.give_back();
      }
    });
  }
  turns.leave();
  for (int round = 0; round < 300; ++round) {
    callback();  // the program's own code
    turns.enter();
    const bool taken = turns.begin();
    callback();
    turns.end(taken);
    turns.leave();
  }
  turns.enter();
  for (std::thread& node : nodes) node.join();
  turns.leave();
  EXPECT_EQ(overlaps, 0);
}

TEST(Turns, ANodeGivesUpWhenItIsStopped) {
  Turns turns;
  turns.enter();
  turns.leave();
  std::atomic<bool> stop{false};
  std::atomic<bool> taken{true};
  std::thread node([&] { taken = turns.take(stop); });
  stop = true;
  node.join();
  EXPECT_FALSE(taken);
}

}  // namespace
}  // namespace catan_ros
