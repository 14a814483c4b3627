#include "runtime/protocol.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace ctn::runtime {
namespace {

TEST(Protocol, RefusesWhatItDoesNotUnderstand) {
  for (const char* text : {"",
                           "{}",
                           "[]",
                           "1",
                           "{\"join\": 1}",
                           "{\"join\": {}}",
                           R"({"join": {"node": "a"}})",
                           R"({"join": {"node": 1, "thread": 1}})",
                           R"({"join": {"node": "a", "thread": 0}})",
                           R"({"join": {"node": "a", "thread": -4}})",
                           R"({"join": {"node": "a", "thread": 1.5}})",
                           R"({"join": {"node": "a", "thread": 4294967297}})",
                           R"({"join": {"node": "a", "thread": 18446744073709551615}})",
                           R"({"join": {"node": "a", "thread": 1, "level": 99}})",
                           R"({"kill": {"node": "a", "thread": 1}})",
                           R"({"join": {"node": "a", "thread": 1}, "leave": {"node": "a"}})",
                           R"({"hello": {"thread": 1}})",
                           R"({"change": {}})",
                           R"({"change": {"version": 2}})",
                           R"({"change": {"version": 2, "weights": []}})",
                           R"({"change": {"cpus": [0]}})",
                           R"({"change": {"version": 2, "cpus": 0}})",
                           R"({"change": {"version": 2, "cpus": [-1]}})",
                           R"({"change": {"version": 2, "cpus": [4294967296]}})",
                           R"({"change": {"version": 2, "cpus": [18446744073709551615]}})",
                           R"({"change": {"version": 2, "weights": [["a", null]]}})",
                           R"({"change": {"version": 2, "weights": [["a"]]}})",
                           R"({"change": {"version": 2, "weights": {"a": 1}}})",
                           R"({"change": {"version": 2, "maxes": [[0, 1]]}})",
                           R"({"change": {"version": 2, "min_rates": [["a", "1"]]}})",
                           R"({"change": {"version": 2, "cpus": [0], "thread": 1}})",
                           R"({"app": {}})",
                           R"({"app": {"version": 2, "name": "a"}})",
                           R"({"status": {}})",
                           R"({"status": {"version": 2, "thread": 1}})",
                           "{\"join\": {\"node\": \"\xff\", \"thread\": 1}}"}) {
    EXPECT_FALSE(parse_request(text).ok()) << text;
  }
}

TEST(Protocol, SaysWhatARefusalSays) {
  const std::string text = to_text(Status(Error::caller("node x is there already", "stop the other")));
  EXPECT_EQ(text, R"({"refused":{"hint":"stop the other","what":"node x is there already"}})");
  const Status reply = parse_reply(text);
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().problems()[0].what, "node x is there already");
  EXPECT_EQ(reply.error().problems()[0].hint, "stop the other");
  EXPECT_TRUE(parse_reply(to_text(Status(Done{}))).ok());
  EXPECT_FALSE(parse_reply("nonsense").ok());
  EXPECT_FALSE(parse_reply(R"({"refused": {"what": 1}})").ok());
}

TEST(Protocol, SaysWhichAppIsScheduled) {
  const Result<std::string> app = parse_app_reply(app_reply("the \"robot\""));
  ASSERT_TRUE(app.ok());
  EXPECT_EQ(*app, "the \"robot\"");
  EXPECT_TRUE(parse_reply(app_reply("robot")).ok()) << "as any other that is granted";
  EXPECT_EQ(parse_app_reply(R"({"refused": {"what": "no", "hint": "none"}})").error().kind(), ErrorKind::kCaller);
  for (const char* text : {"nonsense", R"({"done": {}})", R"({"done": {"app": 1}})"}) {
    EXPECT_EQ(parse_app_reply(text).error().kind(), ErrorKind::kEnvironment) << text;
  }
}

TEST(Protocol, SaysEveryProblemWithItsKey) {
  const Status refused =
      Error(ErrorKind::kCaller, {{{}, "cpus", "CPU 5 is none", "choose"}, {{}, {}, "nothing else", "wait"}});
  EXPECT_EQ(parse_reply(to_text(refused)).error().problems()[0].what, "cpus: CPU 5 is none; nothing else");
}

RC_GTEST_PROP(ProtocolProperty, WhatIsToChangeIsUnderstood, ()) {
  const auto name = rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~'));
  const auto number = rc::gen::map(rc::gen::inRange(-1000, 1000), [](int value) { return value / 8.0; });
  const auto maybe = rc::gen::map(rc::gen::inRange(0, 100),
                                  [](int value) { return value < 20 ? std::nullopt : std::optional(value / 4.0); });
  Request request{.kind = Request::Kind::kChange};
  Changes& changes = request.changes;
  if (*rc::gen::arbitrary<bool>()) changes.cpus = *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 1024));
  for (int count = *rc::gen::inRange(0, 4); count > 0; --count) changes.weights.push_back({*name, *number});
  for (int count = *rc::gen::inRange(0, 4); count > 0; --count) changes.maxes.push_back({*name, *maybe});
  for (int count = *rc::gen::inRange(0, 4); count > 0; --count) changes.min_rates.push_back({*name, *maybe});
  const Result<Request> understood = parse_request(to_text(request));
  RC_ASSERT(understood.ok() == (changes != Changes{}));
  if (understood) RC_ASSERT(*understood == request);
}

RC_GTEST_PROP(ProtocolProperty, WhatIsSaidIsUnderstood, ()) {
  Request request;
  request.kind = *rc::gen::element(Request::Kind::kHello, Request::Kind::kJoin, Request::Kind::kAdd,
                                   Request::Kind::kLeave, Request::Kind::kApp, Request::Kind::kStatus);
  const bool of_control = request.kind == Request::Kind::kApp || request.kind == Request::Kind::kStatus;
  const bool of_program = request.kind == Request::Kind::kHello || of_control;
  if (of_program) request.version = *rc::gen::inRange(1, 100);
  if (request.kind != Request::Kind::kLeave && !of_control) {
    request.thread = *rc::gen::inRange(1, 4194304);
  }
  if (!of_program) {
    request.node = *rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~'));
  }
  const Result<Request> understood = parse_request(to_text(request));
  RC_ASSERT(understood.ok());
  RC_ASSERT(*understood == request);
}

}  // namespace
}  // namespace ctn::runtime
