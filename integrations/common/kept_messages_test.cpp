#include "common/kept_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace catan_ros {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(KeptMessages, TheNewestOfEachTopicIsKept) {
  KeptMessages kept;
  KeptMessages::Topic& left = kept.topic("/left");
  KeptMessages::Topic& right = kept.topic("/right");
  EXPECT_NE(&left, &right);
  EXPECT_EQ(&kept.topic("/left"), &left) << "of another subscription";
  EXPECT_THAT(kept.keys(), IsEmpty());
  right.keep(7);
  EXPECT_THAT(kept.keys(), ElementsAre(7U));
  left.keep(8);
  right.keep(9);
  EXPECT_THAT(kept.keys(), ElementsAre(8U, 9U));
}

TEST(KeptMessages, AMessageHasTheKeyOfTheNewestThatLiesThere) {
  KeptMessages kept;
  KeptMessages::Topic& topic = kept.topic("/data");
  std::array<int, 40> messages{};
  EXPECT_EQ(topic.find(&messages[0]), 0U);
  topic.note_made(&messages[0], 1);
  topic.note_made(&messages[1], 2);
  topic.note_made(&messages[0], 3);
  EXPECT_EQ(topic.find(&messages[0]), 3U);
  EXPECT_EQ(topic.find(&messages[1]), 2U);
  for (const int& message : messages) topic.note_made(&message, 9);
  EXPECT_EQ(topic.find(&messages[0]), 0U) << "too long ago";
  EXPECT_EQ(topic.find(&messages[39]), 9U);
}

}  // namespace
}  // namespace catan_ros
