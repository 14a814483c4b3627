#include "common/message_runs.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace catan_ros {
namespace {

class MessageRunsTest : public testing::Test {
 protected:
  MessageRunsTest() {
    folder_ = testing::TempDir() + "catan-messages-XXXXXX";
    EXPECT_NE(::mkdtemp(folder_.data()), nullptr);
    path = folder_ + "/messages";
    sender = MessageRuns::open(path);
    receiver = MessageRuns::open(path);
  }
  ~MessageRunsTest() override { std::filesystem::remove_all(folder_); }

  static MessageRuns::Key key(const std::string& message, const std::string& topic = "/scan") {
    return MessageRuns::key_of(topic, std::as_bytes(std::span(message.data(), message.size())));
  }

  std::string path;
  std::unique_ptr<MessageRuns> sender;
  std::unique_ptr<MessageRuns> receiver;

 private:
  std::string folder_;
};

TEST_F(MessageRunsTest, WhoGetsAMessageFindsTheRunThatSentIt) {
  sender->note("scan", key("first"), 7);
  sender->note("scan", key("second"), 8);
  EXPECT_EQ(receiver->find("scan", key("first")), 7U);
  EXPECT_EQ(receiver->find("scan", key("second")), 8U);
  EXPECT_EQ(receiver->find("scan", key("third")), 0U);
  EXPECT_EQ(receiver->find("odometry", key("first")), 0U);
  EXPECT_EQ(receiver->find("scan", key("first", "/other")), 0U);
}

TEST_F(MessageRunsTest, OfMessagesWithTheSameBytesTheNewestCounts) {
  sender->note("scan", key("same"), 7);
  sender->note("scan", key("same"), 9);
  EXPECT_EQ(receiver->find("scan", key("same")), 9U);
}

TEST_F(MessageRunsTest, TheLastMessagesAreKept) {
  constexpr std::uint64_t kSent = 4 * MessageRuns::kSets * MessageRuns::kMessagesOfASet;
  for (std::uint64_t run = 1; run <= kSent; ++run) sender->note("scan", key(std::to_string(run)), run);
  std::uint64_t oldest = kSent;
  while (receiver->find("scan", key(std::to_string(oldest))) == oldest) --oldest;
  EXPECT_GT(kSent - oldest, 300U) << "three seconds of a node that sends a hundred in a second";
  EXPECT_EQ(receiver->find("scan", key("1")), 0U);
}

// A map that is built each five seconds, of what a node gave that gives something else fifty times a second.
// Guards: the newest message of all made room for the next, so that only the last of each set was known.
TEST_F(MessageRunsTest, MessagesOfAServerThatWasThereBeforeMakeRoomFirst) {
  constexpr std::uint64_t kBefore = 4 * MessageRuns::kSets * MessageRuns::kMessagesOfASet;
  for (std::uint64_t run = 1; run <= kBefore; ++run) sender->note("scan", key("before " + std::to_string(run)), run);
  constexpr std::uint64_t kSent = 300;
  for (std::uint64_t run = 1; run <= kSent; ++run) sender->note("scan", key(std::to_string(run)), run);
  for (std::uint64_t run = 1; run <= kSent; ++run) {
    EXPECT_EQ(receiver->find("scan", key(std::to_string(run))), run);
  }
}

TEST_F(MessageRunsTest, AMessageThatIsTakenSecondsLaterIsKnownAmongManyOthers) {
  constexpr int kTries = 100;
  int found = 0;
  std::uint64_t run = 0;
  for (int tries = 0; tries < kTries; ++tries) {
    const std::string keyframe = "keyframe " + std::to_string(tries);
    const std::uint64_t sent_by = ++run;
    sender->note("GL", key(keyframe, "/keyframes"), sent_by);
    for (int later = 0; later < 500; ++later) {
      ++run;
      sender->note("GL", key("pose " + std::to_string(run), "/pose"), run);
    }
    found += receiver->find("GL", key(keyframe, "/keyframes")) == sent_by ? 1 : 0;
  }
  EXPECT_GE(found, 95);
}

TEST_F(MessageRunsTest, WhichTopicsAProgramSubscribesIsKnown) {
  receiver->note_subscription("GP", "/map");
  receiver->note_subscription("GP", "/map");
  EXPECT_TRUE(sender->subscribes("GP", "/map"));
  EXPECT_FALSE(sender->subscribes("GP", "/pose"));
  EXPECT_FALSE(sender->subscribes("NC", "/map"));
  for (std::size_t topic = 0; topic <= MessageRuns::kSubscriptions; ++topic) {
    receiver->note_subscription("NC", std::to_string(topic));
  }
  EXPECT_TRUE(sender->subscribes("NC", "0"));
  EXPECT_FALSE(sender->subscribes("NC", std::to_string(MessageRuns::kSubscriptions))) << "more than it holds";
}

TEST_F(MessageRunsTest, WhenANodeLastSentOnATopicIsKnown) {
  const MessageRuns::Time time{std::chrono::milliseconds{5}};
  EXPECT_EQ(receiver->last_time("laser", "/scan"), std::nullopt);
  sender->note_time("laser", "/scan", time);
  sender->note_time("laser", "/scan", time + std::chrono::milliseconds{20});
  sender->note_time("laser", "/state", time);
  EXPECT_EQ(receiver->last_time("laser", "/scan"), time + std::chrono::milliseconds{20});
  EXPECT_EQ(receiver->last_time("camera", "/scan"), std::nullopt);
  for (std::size_t node = 0; node <= MessageRuns::kSenders; ++node) sender->note_time(std::to_string(node), "/a", time);
  EXPECT_EQ(receiver->last_time("0", "/a"), time);
  EXPECT_EQ(receiver->last_time(std::to_string(MessageRuns::kSenders), "/a"), std::nullopt) << "no room";
}

TEST_F(MessageRunsTest, LongMessagesDifferByTheirEnds) {
  std::string image(100'000, 'x');
  const MessageRuns::Key before = key(image);
  image.front() = 'y';
  const MessageRuns::Key other_begin = key(image);
  image.back() = 'y';
  EXPECT_NE(before, other_begin);
  EXPECT_NE(other_begin, key(image));
  EXPECT_NE(key(image), key(image + "y"));
}

TEST_F(MessageRunsTest, NumbersOfTheOtherSignMakeAnotherMessage) {
  const auto key_of_numbers = [](double a, double b) {
    const std::array<double, 2> numbers{a, b};
    return MessageRuns::key_of("/twist", std::as_bytes(std::span(numbers)));
  };
  EXPECT_NE(key_of_numbers(0.5, 0.25), key_of_numbers(-0.5, -0.25));
  EXPECT_NE(key_of_numbers(0.5, 0.25), key_of_numbers(0.25, 0.5));
  EXPECT_EQ(key_of_numbers(0.5, 0.25), key_of_numbers(0.5, 0.25));
}

TEST_F(MessageRunsTest, MoreNodesThanItHoldsAreLeftOut) {
  for (std::size_t node = 0; node <= MessageRuns::kNodes; ++node)
    sender->note(std::to_string(node), key("message"), node + 1);
  EXPECT_EQ(receiver->find("0", key("message")), 1U);
  EXPECT_EQ(receiver->find(std::to_string(MessageRuns::kNodes), key("message")), 0U);
}

TEST_F(MessageRunsTest, WithoutTheFileThereIsNone) {
  EXPECT_EQ(MessageRuns::open("/nowhere/at/all"), nullptr);
  EXPECT_EQ(MessageRuns::open(std::filesystem::path(path).parent_path()), nullptr);
}

}  // namespace
}  // namespace catan_ros
