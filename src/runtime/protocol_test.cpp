#include "runtime/protocol.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

namespace ctn::runtime {
namespace {

TEST(Protocol, RefusesWhatItDoesNotUnderstand) {
  for (const char* text :
       {"", "{}", "[]", "1", "{\"join\": 1}", "{\"join\": {}}", R"({"join": {"node": "a"}})",
        R"({"join": {"node": 1, "thread": 1}})", R"({"join": {"node": "a", "thread": 0}})",
        R"({"join": {"node": "a", "thread": -4}})", R"({"join": {"node": "a", "thread": 1.5}})",
        R"({"join": {"node": "a", "thread": 4294967297}})",
        R"({"join": {"node": "a", "thread": 18446744073709551615}})",
        R"({"join": {"node": "a", "thread": 1, "level": 99}})", R"({"kill": {"node": "a", "thread": 1}})",
        R"({"join": {"node": "a", "thread": 1}, "leave": {"node": "a"}})", R"({"hello": {"thread": 1}})",
        "{\"join\": {\"node\": \"\xff\", \"thread\": 1}}"}) {
    EXPECT_FALSE(parse_request(text).ok()) << text;
  }
}

TEST(Protocol, SaysWhatARefusalSays) {
  const Status reply = parse_reply(to_text(Status(Error::caller("node x is there already", "stop the other"))));
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().problems()[0].what, "node x is there already");
  EXPECT_EQ(reply.error().problems()[0].hint, "stop the other");
  EXPECT_TRUE(parse_reply(to_text(Status(Done{}))).ok());
  EXPECT_FALSE(parse_reply("nonsense").ok());
  EXPECT_FALSE(parse_reply(R"({"refused": {"what": 1}})").ok());
}

RC_GTEST_PROP(ProtocolProperty, WhatIsSaidIsUnderstood, ()) {
  Request request;
  request.kind =
      *rc::gen::element(Request::Kind::kHello, Request::Kind::kJoin, Request::Kind::kAdd, Request::Kind::kLeave);
  if (request.kind == Request::Kind::kHello) request.version = *rc::gen::inRange(1, 100);
  if (request.kind != Request::Kind::kLeave) request.thread = *rc::gen::inRange(1, 4194304);
  if (request.kind != Request::Kind::kHello) {
    request.node = *rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~'));
  }
  const Result<Request> understood = parse_request(to_text(request));
  RC_ASSERT(understood.ok());
  RC_ASSERT(*understood == request);
}

}  // namespace
}  // namespace ctn::runtime
