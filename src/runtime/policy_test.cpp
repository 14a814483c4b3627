#include "runtime/policy.h"

#include <gtest/gtest.h>

#include "runtime/test_app.h"

namespace ctn::runtime {
namespace {

TEST(Policy, KnowsItsNames) {
  EXPECT_TRUE(parse_policy("catan")->follows_plan());
  EXPECT_EQ(parse_policy("fifo")->kind, Policy::Kind::kFifo);
  EXPECT_TRUE(parse_policy("fifo")->raises());
  EXPECT_FALSE(parse_policy("fifo")->follows_plan());
  EXPECT_EQ(parse_policy("static:plans/one.json")->plan, "plans/one.json");
  EXPECT_TRUE(parse_policy("static:plans/one.json")->follows_plan());
  EXPECT_EQ(parse_policy("default")->kind, Policy::Kind::kDefault);
  EXPECT_EQ(parse_policy("rate:30")->rate->hertz(), 30.0);
  EXPECT_EQ(parse_policy("rate:12.5Hz")->rate->hertz(), 12.5);
}

TEST(Policy, SaysWhatWouldBeRight) {
  for (const char* text : {"", "catn", "static:", "fifo:", "rate:", "rate:-3", "rate:fast", "rate:0"}) {
    const Result<Policy> policy = parse_policy(text);
    ASSERT_FALSE(policy.ok()) << text;
    EXPECT_NE(policy.error().message().find("rate:12.5"), std::string::npos);
  }
}

TEST(HandSetRates, TakeTheFallbackOrTheGivenRate) {
  const graph::App app = tracker_app();
  EXPECT_EQ(hand_set_rates(*parse_policy("default"), app)->front().hertz(), 30.0);
  EXPECT_EQ(hand_set_rates(*parse_policy("rate:8"), app)->front().hertz(), 8.0);
}

TEST(HandSetRates, NameEveryHeadThatHasNone) {
  const graph::App app = parse(R"(
catan: 1
app: two
nodes: { a: {}, b: {} }
edges: [ a -> b ]
objective: [ { response_time: [a, b], weight: 1 } ]
)");
  const auto rates = hand_set_rates(*parse_policy("default"), app);
  ASSERT_FALSE(rates.ok());
  EXPECT_EQ(rates.error().problems().size(), 2U);
  EXPECT_EQ(rates.error().problems()[1].key, "nodes.b.fallback_rate");
  EXPECT_EQ(hand_set_rates(*parse_policy("rate:8"), app).error().problems().size(), 1U) << "a is a source";
}

}  // namespace
}  // namespace ctn::runtime
