#include "plan/json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "plan/testing/sample_plan.h"

namespace ctn::plan {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

Plan with_expectation(Plan plan) {
  Expectation& expected = plan.expected.emplace();
  expected.objective = 0.9 * plan.objective;
  for (const SubchainPlan& subchain : plan.subchains) expected.subchains.push_back({subchain.period * 0.9, Millis{1}});
  for (const ChainPlan& chain : plan.chains) {
    expected.chains.push_back({chain.response * 0.9, chain.latency * 0.8, chain.period * 0.7});
  }
  return plan;
}

class PlanJson : public testing::Test {
 protected:
  const graph::App app_ = sample_app();
  const model::CostTable costs_ = sample_costs(app_);
  const Plan plan_ = with_expectation(sample_plan(app_, costs_));
  const std::string text_ = to_json(plan_, app_);

  std::vector<std::string> problems(const std::string& changed) const {
    const Result<Plan> read = from_json(changed, app_, "plan.json");
    std::vector<std::string> messages;
    if (read) return messages;
    EXPECT_EQ(read.error().kind(), ErrorKind::kCaller);
    for (const Problem& problem : read.error().problems()) messages.push_back(to_string(problem));
    return messages;
  }

  std::vector<std::string> problems_after(const std::function<void(json&)>& change) const {
    json document = json::parse(text_);
    change(document);
    return problems(document.dump());
  }
};

TEST_F(PlanJson, SaysWhatPromisesAreFor) {
  EXPECT_EQ(text_.find("promises_for"), std::string::npos) << "left out where it is the planned percentile";
  Plan plan = plan_;
  plan.for_typical = true;
  const std::string text = to_json(plan, app_);
  EXPECT_NE(text.find("\"promises_for\": \"typical\""), std::string::npos);
  const Result<Plan> read = from_json(text, app_, "plan.json");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(*read, plan);
  EXPECT_EQ(problems_after([](json& document) { document["promises_for"] = "mean"; }),
            std::vector<std::string>{"plan.json: promises_for: there are no promises for 'mean'; write percentile or "
                                     "typical"});
}

TEST_F(PlanJson, SaysWhatRunsWait) {
  EXPECT_EQ(text_.find("wait_ms"), std::string::npos) << "left out where they do not";
  Plan plan = plan_;
  plan.subchains[kSlow.index()].wait = Millis{2.5};
  const std::string text = to_json(plan, app_);
  EXPECT_EQ(json::parse(text)["subchains"]["slow"]["wait_ms"], 2.5);
  const Result<Plan> read = from_json(text, app_, "plan.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, plan);
}

TEST_F(PlanJson, SaysWhoGivesFewerOutputsThanItRuns) {
  EXPECT_EQ(text_.find("outputs"), std::string::npos) << "left out where none does";
  Plan plan = plan_;
  plan.outputs = {{NodeId(2), 2.5}};
  const std::string text = to_json(plan, app_);
  EXPECT_EQ(json::parse(text)["outputs"], json::parse(R"([{"node": "map", "runs_per_output": 2.5}])"));
  const Result<Plan> read = from_json(text, app_, "plan.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, plan);
}

TEST_F(PlanJson, SaysHowLargeBatchesMayBe) {
  EXPECT_EQ(text_.find("batches"), std::string::npos) << "left out where no run costs more with each item";
  Plan plan = plan_;
  plan.batches = {{NodeId(3), 7}};
  const std::string text = to_json(plan, app_);
  EXPECT_EQ(json::parse(text)["batches"], json::parse(R"([{"node": "log", "items": 7}])"));
  const Result<Plan> read = from_json(text, app_, "plan.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(*read, plan);
}

TEST_F(PlanJson, SaysWhichCostsWereAssumed) {
  EXPECT_EQ(text_.find("assumed"), std::string::npos) << "left out where none was";
  Plan plan = plan_;
  plan.assumed = {{NodeId(2), Millis{5}}, {NodeId(3), Millis{2.5}}};
  const std::string text = to_json(plan, app_);
  EXPECT_EQ(json::parse(text)["assumed"],
            json::parse(R"([{"node": "map", "cost_ms": 5.0}, {"node": "log", "cost_ms": 2.5}])"));
  const Result<Plan> read = from_json(text, app_, "plan.json");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(*read, plan);
  json document = json::parse(text);
  document["assumed"][0] = {{"node", "nobody"}, {"cost_ms", -1.0}};
  EXPECT_EQ(problems(document.dump()).size(), 2U);
}

TEST_F(PlanJson, ReadsBackWhatItWrote) {
  const Result<Plan> read = from_json(text_, app_, "plan.json");
  ASSERT_TRUE(read.ok()) << read.error().message();
  EXPECT_EQ(*read, plan_);
  EXPECT_EQ(to_json(*read, app_), text_);
}

TEST_F(PlanJson, HasTheKeysOfTheSchema) {
  const json document = json::parse(text_);
  EXPECT_EQ(document["app"], "test");
  EXPECT_EQ(document["status"], "feasible");
  EXPECT_EQ(document["subchains"]["slow"]["every"], 4);
  EXPECT_EQ(document["subchains"]["slow"]["share"], 0.25);
  EXPECT_TRUE(document["subchains"]["log"]["every"].is_null());
  EXPECT_EQ(document["subchains"]["see"]["cores"], json::parse("[1, 2]"));
  EXPECT_EQ(document["cores"][0]["slots"][1]["subchain"], "slow");
  EXPECT_EQ(document["cores"][0]["frames"], "elastic");
  EXPECT_EQ(document["chains"][0]["path"], json::parse(R"(["scan", "steer", "base"])"));
  EXPECT_EQ(document["nodes"][0]["node"], "log");
  EXPECT_EQ(document["relaxed"]["bounds"][0]["bound"], "objective[1].max");
}

TEST_F(PlanJson, TakesWholeNumbersForMilliseconds) {
  EXPECT_THAT(problems_after([](json& d) { d["cores"][0]["idle_ms"] = 2; }), testing::IsEmpty());
}

TEST_F(PlanJson, SaysWhereTheTextIsNoJson) {
  const auto found = problems("{\n \"app\": \"test\",\n oops }");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0], HasSubstr("plan.json:3:2: the text is not JSON"));
}

TEST_F(PlanJson, RejectsTextThatIsNoPlan) {
  for (const char* broken : {"", "null", "[]", "3", "{", "\"plan\"", "\xff\xfe", "{\"gap\": 1e999}", "{} {}"}) {
    EXPECT_FALSE(problems(broken).empty()) << broken;
  }
  const std::string deep(200'000, '[');
  EXPECT_FALSE(problems(deep).empty());
  const std::string deep_value = "{\"gap\": " + deep + std::string(200'000, ']') + "}";
  EXPECT_FALSE(problems(deep_value).empty());
}

TEST_F(PlanJson, RejectsADoubledKey) {
  const auto found = problems("{\"cores\": [{\"slots\": 1, \"slots\": 2}]}");
  EXPECT_THAT(found, Contains(HasSubstr("cores.slots: the key is there twice")));
}

TEST_F(PlanJson, NamesUnknownAndMissingKeysByTheirPath) {
  EXPECT_THAT(problems_after([](json& d) { d["cores"][0]["slots"][1]["phases"] = 1; }),
              Contains(HasSubstr("cores[0].slots[1].phases: unknown key")));
  EXPECT_THAT(problems_after([](json& d) { d["subchains"]["fast"].erase("share"); }),
              Contains(HasSubstr("subchains.fast.share: the key is missing")));
  EXPECT_THAT(problems_after([](json& d) { d["subchains"].erase("fast"); }),
              Contains(HasSubstr("subchains.fast: the subchain is missing")));
}

// Whatever stands in the wrong place is noticed: every value of the document, replaced by one of another type.
TEST_F(PlanJson, RejectsEveryValueOfTheWrongType) {
  const json document = json::parse(text_);
  const json flat = document.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    for (const json& other : {json(true), json(json::object()), json("text"), json(-1)}) {
      json changed = document;
      changed[json::json_pointer(pointer)] = other;
      // Text that is any text, and no reference to the app, is as good as any other.
      if (other.is_string() && (pointer == "/planner" || pointer.ends_with("/bound"))) continue;
      EXPECT_FALSE(problems(changed.dump()).empty()) << pointer << " = " << other;
    }
  }
}

TEST_F(PlanJson, NamesWhatTheAppHasNot) {
  EXPECT_THAT(problems_after([](json& d) { d["app"] = "other"; }), Contains(HasSubstr("the plan is for app 'other'")));
  EXPECT_THAT(problems_after([](json& d) { d["subchains"]["ghost"] = 1; }), Contains(HasSubstr("subchains.ghost")));
  EXPECT_THAT(problems_after([](json& d) { d["cores"][0]["slots"][0]["subchain"] = "ghost"; }),
              Contains(HasSubstr("cores[0].slots[0].subchain: app 'test' has no subchain 'ghost'")));
  EXPECT_THAT(problems_after([](json& d) { d["chains"][0]["path"][1] = "ghost"; }),
              Contains(HasSubstr("chains[0].path[1]: \"ghost\" is no node")));
  EXPECT_THAT(problems_after([](json& d) { d["nodes"][0]["node"] = "ghost"; }),
              Contains(HasSubstr("nodes[0].node: \"ghost\" is no node")));
  EXPECT_THAT(problems_after([](json& d) { d["status"] = "good"; }), Contains(HasSubstr("status: there is no status")));
  EXPECT_THAT(problems_after([](json& d) { std::swap(d["cores"][0], d["cores"][1]); }),
              Contains(HasSubstr("cores[0].core: core 1 stands where core 0 belongs")));
}

TEST_F(PlanJson, ReportsAllProblemsAtOnce) {
  const auto found = problems_after([](json& d) {
    d["gap"] = "none";
    d["cores"][0]["idle_ms"] = -1;
    d["relaxed"]["factor"] = nullptr;
  });
  EXPECT_EQ(found.size(), 3U);
}

RC_GTEST_PROP(PlanJsonProperty, RoundTripsEveryDouble, ()) {
  const graph::App app = sample_app();
  Plan plan = sample_plan(app, sample_costs(app));
  const auto any = [] {
    return std::ldexp(*rc::gen::inRange(0, 1 << 30) * 1.0 + 1.0 / 3.0, *rc::gen::inRange(-300, 300));
  };
  plan.objective = any();
  plan.subchains[0].period = Millis{any()};
  plan.cores[0].slots[0].slice = Millis{any()};
  plan.chains[0].latency = Millis{any()};
  plan.relaxed[0].asked = Millis{any()};
  const Result<Plan> read = from_json(to_json(plan, app), app, "plan.json");
  RC_ASSERT(read.ok());
  RC_ASSERT(*read == plan);
}

}  // namespace
}  // namespace ctn::plan
