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
  for (std::uint64_t run = 1; run <= 2 * MessageRuns::kMessages; ++run)
    sender->note("scan", key(std::to_string(run)), run);
  const std::uint64_t oldest = MessageRuns::kMessages + 1;
  EXPECT_EQ(receiver->find("scan", key(std::to_string(oldest))), oldest);
  EXPECT_EQ(receiver->find("scan", key(std::to_string(oldest - 1))), 0U);
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
