// What clients send is parsed and checked: heads of requests, access, changes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "web/access.h"
#include "web/change_request.h"
#include "web/request_head.h"

namespace ctn::web {
namespace {

using testing::HasSubstr;

std::variant<RequestHead, Refusal> parsed(const std::string& text) {
  EXPECT_EQ(head_length(text), text.size()) << text;
  return parse_head(text);
}

RequestHead accepted(const std::string& text) {
  const auto head = parsed(text);
  EXPECT_TRUE(std::holds_alternative<RequestHead>(head)) << text;
  return std::holds_alternative<RequestHead>(head) ? std::get<RequestHead>(head) : RequestHead{};
}

// 0: it is accepted.
int refused(const std::string& text) {
  const auto head = parsed(text);
  return std::holds_alternative<Refusal>(head) ? std::get<Refusal>(head).status : 0;
}

TEST(RequestHeadTest, EndsAtTheEmptyLine) {
  EXPECT_EQ(head_length("GET / HTTP/1.1\r\n\r\nbody"), 18U);
  EXPECT_EQ(head_length("GET / HTTP/1.1\r\nHost: a\r\n"), std::nullopt);
  EXPECT_EQ(head_length(""), std::nullopt);
  EXPECT_EQ(head_length("GET / HTTP/1.1\n\n"), std::nullopt);
}

TEST(RequestHeadTest, KeepsWhatIsUsed) {
  const RequestHead head = accepted(
      "POST /control/change?a=b HTTP/1.1\r\nhOST:  localhost:80 \r\nX-Other: 1\r\nOrigin: http://localhost:80\r\n"
      "Authorization: Bearer x\r\nContent-Length: 7\r\nExpect: 100-Continue\r\n\r\n");
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.target, "/control/change?a=b");
  EXPECT_EQ(head.path(), "/control/change");
  EXPECT_EQ(head.host, "localhost:80");
  EXPECT_EQ(head.origin, "http://localhost:80");
  EXPECT_EQ(head.authorization, "Bearer x");
  EXPECT_EQ(head.content_length, 7U);
  EXPECT_TRUE(head.keep_alive);
  EXPECT_TRUE(head.expects_continue);
  EXPECT_EQ(canonical(head),
            "POST /control/change?a=b HTTP/1.1\r\nContent-Type: application/json\r\nContent-Length: 7\r\n\r\n");
}

TEST(RequestHeadTest, WhatAltersBodiesAndAnswersDoesNotGoOn) {
  const RequestHead head = accepted(
      "GET /live HTTP/1.1\r\nHost: a\r\nRange: bytes=0-,0-,0-\r\nAccept-Encoding: gzip\r\nUpgrade: x\r\n"
      "Content-Type: multipart/form-data\r\nConnection: Upgrade, CLOSE\r\n\r\n");
  EXPECT_EQ(canonical(head), "GET /live HTTP/1.1\r\nConnection: close\r\n\r\n");
}

TEST(RequestHeadTest, ConnectionsAreKeptAsTheClientWants) {
  EXPECT_TRUE(accepted("GET / HTTP/1.1\r\n\r\n").keep_alive);
  EXPECT_FALSE(accepted("GET / HTTP/1.0\r\n\r\n").keep_alive);
  EXPECT_TRUE(accepted("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n").keep_alive);
  EXPECT_FALSE(accepted("GET / HTTP/1.1\r\nConnection: close\r\nConnection: keep-alive\r\n\r\n").keep_alive);
}

TEST(RequestHeadTest, WhatIsNoPlainRequestIsRefused) {
  for (const char* line :
       {"", "GET", "GET /", "GET  HTTP/1.1", "GET x HTTP/1.1", "GET http://a/ HTTP/1.1", "GET / / HTTP/1.1",
        "GET /\t HTTP/1.1", "GET /\x80 HTTP/1.1", "G T / HTTP/1.1", "G(T / HTTP/1.1"}) {
    EXPECT_EQ(refused(std::string(line) + "\r\nHost: a\r\n\r\n"), 400) << line;
  }
  for (const char* line : {"GET / HTTP/2.0", "GET / HTTP/1.10", "GET / http/1.1"}) {
    EXPECT_EQ(refused(std::string(line) + "\r\n\r\n"), 505) << line;
  }
  for (const char* line : {"PUT / HTTP/1.1", "OPTIONS / HTTP/1.1", "get / HTTP/1.1", "CONNECT / HTTP/1.1"}) {
    EXPECT_EQ(refused(std::string(line) + "\r\n\r\n"), 405) << line;
  }
  EXPECT_EQ(refused("GET /" + std::string(kMaxTarget, 'a') + " HTTP/1.1\r\n\r\n"), 414);
  EXPECT_EQ(refused("GET /" + std::string(kMaxTarget - 1, 'a') + " HTTP/1.1\r\n\r\n"), 0);
}

TEST(RequestHeadTest, WrongHeadersAreRefused) {
  const std::string get = "GET / HTTP/1.1\r\n";
  const std::string post = "POST / HTTP/1.1\r\n";
  for (const std::string& header : std::vector<std::string>{
           "no colon", ": x", "a b: x", " folded: x", std::string("a: \0", 4), std::string("a: b\x7F"), "a: b\rc",
           "Host: a\r\nHost: a", "Origin: a\r\nOrigin: a", "Authorization: a\r\nAuthorization: a", "Content-Length: 1",
           "Content-Length: 0\r\nContent-Length: 0"}) {
    EXPECT_EQ(refused(get + header + "\r\n\r\n"), 400) << header;
  }
  for (const std::string length : {"", "-1", "+1", "0x10", "1, 1", "1 1"}) {
    EXPECT_EQ(refused(post + "Content-Length: " + length + "\r\n\r\n"), 400) << length;
  }
  EXPECT_EQ(refused(post + "Content-Length: 65536\r\n\r\n"), 0);
  EXPECT_EQ(refused(post + "Content-Length: 65537\r\n\r\n"), 413);
  EXPECT_EQ(refused(post + "Content-Length: 99999999999999999999999\r\n\r\n"), 413);
  EXPECT_EQ(refused(post + "\r\n"), 411);
  EXPECT_EQ(refused(post + "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n"), 501);
  EXPECT_EQ(refused(post + "Content-Length: 1\r\nContent-Encoding: gzip\r\n\r\n"), 415);
  EXPECT_EQ(refused(post + "Content-Length: 1\r\nExpect: tea\r\n\r\n"), 417);
  std::string many = get;
  for (std::size_t i = 0; i < kMaxHeaders; ++i) many += "a: b\r\n";
  EXPECT_EQ(refused(many + "\r\n"), 0);
  EXPECT_EQ(refused(many + "a: b\r\n\r\n"), 431);
}

RequestHead request(const std::string& target, const std::string& host) {
  RequestHead head{.method = "GET", .target = target};
  head.host = host;
  return head;
}

int verdict(const RequestHead& head, const AccessRules& rules) {
  const auto refusal = check_access(head, rules);
  return refusal ? refusal->status : 0;
}

TEST(AccessTest, OnLoopbackOnlyNamesOfThisMachineAreAnswered) {
  for (const char* host : {"localhost", "LocalHost:8080", "127.0.0.1:1", "127.1.2.3", "[::1]", "[::1]:8080"}) {
    EXPECT_EQ(verdict(request("/", host), {}), 0) << host;
  }
  for (const char* host : {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "10.0.0.1", "[::2]",
                           "[::1", "[::1]x", "::1", "localhost:80:80", "evil.example:8080"}) {
    EXPECT_EQ(verdict(request("/", host), {}), 403) << host;
    EXPECT_EQ(verdict(request("/", host), {.loopback_only = false}), 0) << host;
  }
  EXPECT_EQ(verdict({.method = "GET", .target = "/"}, {}), 400);
}

TEST(AccessTest, ControlNeedsTheToken) {
  const AccessRules rules{.token = "0123456789abcdef"};
  RequestHead head = request("/control/change", "localhost:8080");
  EXPECT_EQ(verdict(head, {}), 403);
  EXPECT_EQ(verdict(head, rules), 401);
  for (const char* given : {"", "0123456789abcdef", "Bearer", "Bearer ", "Bearer 0123456789abcde",
                            "Bearer 0123456789abcdeF", "Bearer 0123456789abcdef0", "bearer 0123456789abcdef",
                            "Basic 0123456789abcdef", "Bearer 0123456789abcdef0123456789abcdef"}) {
    head.authorization = given;
    EXPECT_EQ(verdict(head, rules), 401) << given;
  }
  head.authorization = "Bearer 0123456789abcdef";
  EXPECT_EQ(verdict(head, rules), 0);
  EXPECT_EQ(verdict(head, {}), 403);
  for (const char* origin : {"null", "http://evil.example", "https://localhost:8080", "http://localhost:8081"}) {
    head.origin = origin;
    EXPECT_EQ(verdict(head, rules), 403) << origin;
  }
  head.origin = "http://localhost:8080";
  EXPECT_EQ(verdict(head, rules), 0);
}

TEST(AccessTest, WhatIfIsForPagesOfThisServer) {
  RequestHead head = request("/whatif", "localhost:8080");
  EXPECT_EQ(verdict(head, {}), 0);
  head.origin = "http://localhost:8080";
  EXPECT_EQ(verdict(head, {}), 0);
  for (const char* origin : {"null", "http://evil.example", "https://localhost:8080"}) {
    head.origin = origin;
    EXPECT_EQ(verdict(head, {}), 403) << origin;
    EXPECT_EQ(verdict(head, {.loopback_only = false}), 403) << origin;
  }
  head.target = "/whatif?x=1";
  EXPECT_EQ(verdict(head, {}), 403);
  head.target = "/live";
  EXPECT_EQ(verdict(head, {}), 0);
}

TEST(AccessTest, TokensAreLongEnoughAndPlain) {
  EXPECT_EQ(*token_from(" 0123456789abcdef\n"), "0123456789abcdef");
  for (const std::string text : {"", "0123456789abcde", "0123456789 abcdef",
                                 "0123456789\x01"
                                 "abcdef"}) {
    EXPECT_FALSE(token_from(text).ok()) << text;
  }
  EXPECT_TRUE(token_from(std::string(256, 'x')).ok());
  EXPECT_FALSE(token_from(std::string(257, 'x')).ok());
}

TEST(ChangeRequestTest, IsWhatAServerIsAskedFor) {
  const auto changes =
      parse_change(R"({"cpus": [0, 2], "weights": [["scan -> LM", 0.5]], "maxes": [["0", 60.0], ["1", null]],)"
                   R"( "min_rates": [["GL", 2]]})");
  ASSERT_TRUE(changes.ok()) << changes.error().message();
  Changes wanted;
  wanted.cpus = {0, 2};
  wanted.weights = {{"scan -> LM", 0.5}};
  wanted.maxes = {{"0", 60.0}, {"1", std::nullopt}};
  wanted.min_rates = {{"GL", 2.0}};
  EXPECT_EQ(*changes, wanted);
}

TEST(ChangeRequestTest, WhatIsNotUnderstoodIsTheCallersMistake) {
  for (const std::string& text :
       {std::string(), std::string("{}"), std::string("[]"), std::string("null"), std::string("{\"weights\": 1}"),
        std::string("{\"weights\": [[\"a\", \"b\"]]}"), std::string("{\"weights\": [[\"a\", 1]], \"more\": 1}"),
        std::string("{\"version\": 2, \"weights\": [[\"a\", 1]]}"), std::string("{\"cpus\": [-1]}"),
        std::string(60'000, '['), "{\"weights\": " + std::string(100, '[') + std::string(100, ']') + "}",
        std::string("{\"weights\": [[\"\xFF\", 1]]}")}) {
    const auto changes = parse_change(text);
    ASSERT_FALSE(changes.ok()) << text.substr(0, 80);
    EXPECT_EQ(changes.error().kind(), ErrorKind::kCaller);
  }
}

TEST(WhatIfRequestTest, IsAChangeWithCostsAndCores) {
  const auto asked = parse_what_if(R"({"weights": [["0", 2]], "costs": {"LM": "5ms", "GL": "x2"}, "cores": 4})");
  ASSERT_TRUE(asked.ok()) << asked.error().message();
  WhatIf wanted;
  wanted.changes.weights = {{"0", 2.0}};
  wanted.costs = {{"LM", "5ms"}, {"GL", "x2"}};
  wanted.cores = 4;
  EXPECT_EQ(*asked, wanted);
  EXPECT_EQ(parse_what_if("{}").value(), WhatIf{}) << "what would be planned now";
}

TEST(WhatIfRequestTest, WhatIsNotUnderstoodIsTheCallersMistake) {
  for (const char* text : {"", "[]", R"({"costs": []})", R"({"costs": {"LM": 5}})", R"({"cores": 0})",
                           R"({"cores": 65})", R"({"cores": 1.5})", R"({"cores": "2"})", R"({"more": 1})",
                           R"({"cores": 2, "weights": 1})", R"({"version": 2})"}) {
    const auto asked = parse_what_if(text);
    ASSERT_FALSE(asked.ok()) << text;
    EXPECT_EQ(asked.error().kind(), ErrorKind::kCaller) << text;
  }
}

TEST(ChangeRequestTest, ErrorsAreJson) {
  EXPECT_EQ(error_json("a \"b\"\n", "c"), "{\"error\":\"a \\\"b\\\"\\n\",\"hint\":\"c\"}\n");
  const Error error(ErrorKind::kCaller, {{{}, "k", "one", "do"}, {{}, "", "two", ""}});
  EXPECT_EQ(error_json(error), "{\"error\":\"k: one; two\",\"hint\":\"do\"}\n");
}

}  // namespace
}  // namespace ctn::web
