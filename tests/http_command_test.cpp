// catan http and catan serve --http from outside: the real command, asked over real sockets. Times are generous: it is
// the real machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "command_test.h"
#include "os/linux/tcp.h"
#include "served_app.h"

namespace ctn::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class HttpCommand : public ServedNodesTest {
 protected:
  void serve_page(const std::string& more) {
    ASSERT_NO_FATAL_FAILURE(serve_all("--http 127.0.0.1:0 " + more));
    find_page();
  }
  // Where the page is, as who serves it says.
  void find_page() {
    const std::string before = "the page is at http://";
    ASSERT_TRUE(says(before)) << said();
    ASSERT_TRUE(eventually([&] { return said().find('/', said().find(before) + before.size()) != std::string::npos; }));
    const std::string text = said();
    const std::size_t begin = text.find(before) + before.size();
    address_ = os::parse_tcp_address(text.substr(begin, text.find('/', begin) - begin)).value();
    ASSERT_NE(address_.port, 0);
  }
  // Empty: no server listens there.
  std::string ask_page(const std::string& request) {
    const TimePoint deadline = os_->now() + seconds{10};
    const auto client = os::TcpConnection::connect(address_, deadline);
    if (!client || client->send(request, deadline) != os::TcpConnection::Outcome::kDone) return {};
    std::string text;
    char buffer[4096];
    while (true) {
      const auto got = client->receive(buffer, sizeof buffer, deadline);
      if (got.outcome != os::TcpConnection::Outcome::kDone) return text;
      text.append(buffer, got.bytes);
    }
  }
  std::string get_page(const std::string& target) {
    return ask_page("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  }
  std::string change(const std::string& body, const std::string& token) {
    return ask_page("POST /control/change HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " +
                    token + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }
  std::string what_if(const std::string& body, const std::string& headers = {}) {
    return ask_page("POST /whatif HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + headers +
                    "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }
  static nlohmann::json body_of(const std::string& answer) {
    return nlohmann::json::parse(answer.substr(answer.find("\r\n\r\n") + 4), nullptr, false);
  }

  os::TcpAddress address_;
};

TEST_F(HttpCommand, ShowsWhatAServerDoesAndChangesNothing) {
  serve_page("");
  EXPECT_THAT(get_page("/"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("<html")));
  ASSERT_TRUE(eventually([&] { return body_of(get_page("/live"))["chains"][0]["newest_ms"].is_number(); }));
  const nlohmann::json live = body_of(get_page("/live"));
  EXPECT_EQ(live["app"], "served");
  EXPECT_EQ(live["state"], "running");
  EXPECT_EQ(live["chains"][0]["path"], "eye -> hand");
  EXPECT_EQ(body_of(get_page("/snapshot"))["policy"], "catan");
  EXPECT_EQ(body_of(get_page("/plan"))["app"], "served");
  EXPECT_EQ(body_of(get_page("/timeline"))["lanes"], (nlohmann::json{"fast", "slow"}));
  EXPECT_THAT(get_page("/metrics"),
              AllOf(HasSubstr("\ncatan_up 1\n"), HasSubstr("catan_response_time_seconds_count{chain=\"eye -> hand\"}"),
                    HasSubstr("catan_cpu_busy_ratio{cpu=")));
  EXPECT_THAT(change(R"({"weights": [["0", 0.5]]})", "0123456789abcdef"), StartsWith("HTTP/1.1 403"));
  EXPECT_EQ(body_of(get_page("/snapshot"))["changes"], 0);
  EXPECT_EQ(kill_server(SIGTERM), os::Exit{});
  EXPECT_TRUE(eventually([&] { return get_page("/").empty(); }));
}

TEST_F(HttpCommand, IsGoneWithAServerThatIsKilled) {
  serve_page("");
  kill_server(SIGKILL);
  EXPECT_TRUE(eventually([&] { return get_page("/").empty(); }));
}

// However often it is asked meanwhile.
TEST_F(HttpCommand, FindsAServerAgainThatWasKilled) {
  serve();
  ASSERT_TRUE(eventually([&] { return std::filesystem::exists(path("socket")); }));
  const auto page = os::ChildProcess::start(
      {"/bin/sh", "-c", "exec \"$0\" http \"$1\" --listen 0 2>>\"$2\"", CATAN_COMMAND, path("socket"), path("said")});
  ASSERT_TRUE(page.ok()) << page.error().message();
  find_page();
  EXPECT_TRUE(eventually([&] { return body_of(get_page("/live"))["state"] == "running"; }));
  kill_server(SIGKILL);
  EXPECT_TRUE(eventually([&] { return body_of(get_page("/live"))["state"] == "killed"; }));
  serve();
  EXPECT_TRUE(eventually([&] { return body_of(get_page("/live"))["state"] == "running"; }));
}

TEST_F(HttpCommand, ServesFromCpusThatTheAppDoesNotUse) {
  serve_all();
  expect_off_the_apps_cpu("http " + path("socket") + " --listen 0");
}

TEST_F(HttpCommand, ChangesWhatIsAskedWithTheToken) {
  std::ofstream(path("token")) << "0123456789abcdef\n";
  ::chmod(path("token").c_str(), 0600);
  serve_page("--allow-control --token-file " + path("token"));
  EXPECT_THAT(change(R"({"weights": [["0", 2.5]]})", "0123456789abcdeF"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(change(R"({"weights": [["none", 2.5]]})", "0123456789abcdef"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(change(R"({"weights": [["eye -> hand", 2.5]]})", "0123456789abcdef"), StartsWith("HTTP/1.1 200"));
  EXPECT_TRUE(says("objective[0].weight (eye -> hand): 1 -> 2.5")) << said();
  EXPECT_TRUE(eventually([&] { return body_of(get_page("/live"))["chains"][0]["weight"] == 2.5; }));
  EXPECT_EQ(said().find("0123456789abcdef"), std::string::npos);
}

TEST_F(HttpCommand, SaysWhatWouldBePlannedAndChangesNothing) {
  serve_page("");
  ASSERT_TRUE(eventually([&] { return body_of(get_page("/live"))["chains"][0]["newest_ms"].is_number(); }));
  const std::string answer = what_if(R"({"weights": [["0", 3]], "maxes": [["0", 500]], "costs": {"map": "50ms"}})");
  ASSERT_THAT(answer, StartsWith("HTTP/1.1 200"));
  const nlohmann::json said = body_of(answer);
  EXPECT_EQ(said["app"], "served");
  EXPECT_EQ(said["then"]["cores"], 1);
  EXPECT_EQ(said["then"]["feasible"], true);
  ASSERT_EQ(said["chains"].size(), 1U);
  EXPECT_EQ(said["chains"][0]["path"], "eye -> hand");
  EXPECT_EQ(said["chains"][0]["weight"], 3.0);
  EXPECT_EQ(said["chains"][0]["bound_ms"], 500.0);
  EXPECT_GT(said["chains"][0]["now"]["promised_ms"], 0.0);
  EXPECT_GT(said["chains"][0]["then"]["expected_ms"], 0.0);
  ASSERT_EQ(said["subchains"].size(), 2U);
  EXPECT_EQ(said["subchains"][1]["subchain"], "slow");
  EXPECT_GT(said["subchains"][1]["then"]["period_ms"], 50.0) << "no run ends sooner";

  const nlohmann::json on_two = body_of(what_if(R"({"cores": 2})"));
  EXPECT_EQ(on_two["now"]["cores"], 1);
  EXPECT_EQ(on_two["then"]["cores"], 2);
  const nlohmann::json tight = body_of(what_if(R"({"maxes": [["0", 1]], "costs": {"eye": "x20"}})"));
  EXPECT_EQ(tight["then"]["feasible"], false);
  EXPECT_EQ(tight["then"]["relaxed"][0]["bound"], "objective[0].max");

  const auto expect_refused = [&](const std::string& body, const std::string& why) {
    EXPECT_THAT(what_if(body), AllOf(StartsWith("HTTP/1.1 400"), HasSubstr(why))) << body;
  };
  expect_refused(R"({"weights": [["none", 1]]})", "none");
  expect_refused(R"({"costs": {"none": "x2"}})", "no node");
  expect_refused(R"({"costs": {"eye": "2"}})", "not a compute time");
  expect_refused(R"({"costs": {"eye": "x0"}})", "not a factor");
  expect_refused(R"({"cpus": [999]})", "not among those");
  expect_refused(R"({"cpus": [0], "cores": 1})", "one of them");
  EXPECT_THAT(what_if("{}", "Origin: http://evil.example\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_EQ(body_of(get_page("/snapshot"))["changes"], 0);
}

TEST_F(HttpCommand, WhereItCannotListenTheAppIsScheduledAllTheSame) {
  const auto taken = os::TcpListener::open({"127.0.0.1", 0});
  ASSERT_TRUE(taken.ok());
  serve("socket", "app.yaml", "", "--http " + os::to_string(taken->address()));
  EXPECT_TRUE(says("another program does")) << said();
  EXPECT_TRUE(says("the page is gone; the app is scheduled as before")) << said();
  play({"eye", "hand", "map"});
  EXPECT_TRUE(says("subchain fast runs")) << said();
}

TEST_F(HttpCommand, WhatIsWrongIsToldAtOnce) {
  const auto expect = [&](const std::string& arguments, int code, const std::string& why) {
    const Outcome outcome = run_catan(arguments, folder_);
    EXPECT_EQ(outcome.exit_code, code) << arguments << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why)) << arguments;
  };
  expect("http no_such_app", 2, "no_such_app");
  expect("http --listen example.org:80", 2, "127.0.0.1:8080");
  expect("http --listen 0 --token-file token", 2, "--allow-control");
  expect("http --listen 0 --allow-control --token-file none", 2, "no token can be read from");
  std::ofstream(path("short")) << "short\n";
  expect("http --listen 0 --allow-control --token-file short", 2, "16 to 256");
  expect("serve app.yaml --http 1.2.3:4", 2, "127.0.0.1:8080");
  expect("serve app.yaml --allow-control", 2, "--http");
}

}  // namespace
}  // namespace ctn::test
