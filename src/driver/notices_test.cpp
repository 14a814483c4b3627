#include "driver/notices.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ctn::driver {
namespace {

TEST(Notices, AreToldInOrderAndKept) {
  std::vector<std::string> told;
  const auto tell = [&](const std::string& text) { told.push_back(text); };
  int added = 0;
  Notices notices([&] { ++added; }, true);
  notices.add({{}, "a", "1"});
  notices.add({{}, "b", "2"});
  EXPECT_TRUE(told.empty()) << "the callback is not called by the thread that adds";
  EXPECT_EQ(added, 2);
  notices.deliver(tell);
  notices.deliver(tell);
  EXPECT_EQ(told, (std::vector<std::string>{"a: 1", "b: 2"}));
  EXPECT_EQ(notices.newest(), told);
  EXPECT_EQ(notices.take_unrecorded().size(), 2U);
  EXPECT_TRUE(notices.take_unrecorded().empty());
}

TEST(Notices, WhatTheCallbackAddsIsToldToo) {
  std::vector<std::string> told;
  Notices notices([] {}, false);
  notices.add({{}, "a", "1"});
  notices.deliver([&](const std::string& text) {
    told.push_back(text);
    if (told.size() == 1) notices.add({{}, "b", "2"});
  });
  EXPECT_EQ(told, (std::vector<std::string>{"a: 1", "b: 2"}));
}

TEST(Notices, WhatIsNotDeliveredIsKeptForSnapshotsAlone) {
  Notices notices({}, false);
  for (int number = 0; number < 1500; ++number) notices.add({{}, "n", std::to_string(number)});
  notices.deliver([](const std::string& text) { ADD_FAILURE() << text; });
  EXPECT_EQ(notices.newest().size(), 1000U);
  EXPECT_EQ(notices.newest().back(), "n: 1499");
}

}  // namespace
}  // namespace ctn::driver
