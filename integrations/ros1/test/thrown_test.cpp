#include "ros1/thrown.h"

#include <gtest/gtest.h>
#include <ros/callback_queue.h>

#include <atomic>
#include <functional>
#include <stdexcept>

#include <boost/make_shared.hpp>

#include "common/bound_callback.h"
#include "common/testing/played_runs.h"

namespace catan_ros {
namespace {

class Throwing final : public ros::CallbackInterface {
 public:
  CallResult call() override { throw std::range_error("of the callback"); }
};

class NoTurn final : public Turn {
 public:
  bool take(const std::atomic<bool>&) override { return true; }
  void give_back() override {}
};

// In a run of a node, by this thread.
void call_in_run(const std::function<bool()>& call) {
  Inbox inbox;
  NoTurn turn;
  Play play;
  play.trigger();
  play.finish();
  PlayedRuns runs(play);
  BoundCallback bound({}, inbox, turn);
  bound.set_without_message(call);
  bound.run(runs);
}

TEST(Thrown, ComesOutOfTheProgramsSpinnerOnce) {
  ros::CallbackQueue queue;
  const auto call = handing_on_exceptions(ros::CallbackInterfacePtr(boost::make_shared<Throwing>()), queue);
  EXPECT_NO_THROW(call_in_run([&] { return call() == Outcome::kCalled; }));
  EXPECT_THROW(queue.callAvailable(), std::range_error);
  EXPECT_NO_THROW(queue.callAvailable());
}

TEST(Thrown, SoDoesWhatATimersFunctionThrows) {
  ros::CallbackQueue queue;
  EXPECT_NO_THROW(call_in_run(handing_on_exceptions([]() -> bool { throw std::range_error("of the timer"); }, queue)));
  EXPECT_THROW(queue.callAvailable(), std::range_error);
}

TEST(Thrown, OutsideOfARunItIsThrownAsItIs) {
  ros::CallbackQueue queue;
  const auto call = handing_on_exceptions(ros::CallbackInterfacePtr(boost::make_shared<Throwing>()), queue);
  EXPECT_THROW(call(), std::range_error);
  EXPECT_TRUE(queue.isEmpty());
}

}  // namespace
}  // namespace catan_ros
