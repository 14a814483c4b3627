// The server over real sockets of the loopback interface, with a source that is played. What must take a time is waited
// for, and nothing is asked to be fast.
#include "web/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/guarded.h"
#include "os/linux/linux_os.h"

namespace ctn::web {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Outcome = os::TcpConnection::Outcome;

constexpr const char* kToken = "0123456789abcdef";

class PlayedSource final : public Source {
 public:
  Result<std::string> live() override {
    ++asked;
    return *live_text.lock();
  }
  Result<std::string> timeline() override { return std::string("{\"lanes\":[]}"); }
  Result<std::string> snapshot() override { return *snapshot_text.lock(); }
  Result<std::string> plan() override { return Error::environment("there is no plan", "wait"); }
  Status change(const Changes& changes) override {
    changed.lock()->push_back(changes);
    if (!changes.weights.empty() && changes.weights.front().term == "none") {
      return Error::caller("there is no such term", "name another");
    }
    return Done{};
  }
  Result<std::string> what_if(const WhatIf& question) override {
    questions.lock()->push_back(question);
    while (thinking.load()) std::this_thread::sleep_for(milliseconds{1});
    if (question.cores == 9) return Error::caller("there are no nine cores", "ask for fewer");
    return std::string("{\"then\":1}");
  }

  std::atomic<int> asked{0};
  std::atomic<bool> thinking{false};
  Guarded<std::vector<WhatIf>> questions;
  Guarded<Result<std::string>> live_text{std::string("{\"app\":\"played\",\n \"up_s\":1}")};
  Guarded<Result<std::string>> snapshot_text{std::string("{\"plans\":3}")};
  Guarded<std::vector<Changes>> changed;
};

class WebServerTest : public testing::Test {
 protected:
  ~WebServerTest() override { stop(); }

  void start(const Limits& limits, std::optional<std::string> token = std::nullopt) {
    server_ = Server::open(*os_, source_, {"127.0.0.1", 0}, std::move(token), limits).value();
    thread_ = os_->spawn("server", [this] { server_->run(); });
  }
  void start() { start(Limits{}); }
  void stop() {
    if (server_) server_->stop();
    thread_.reset();
  }
  // Whatever a client waits for comes far sooner, or the test fails.
  TimePoint at_last() { return os_->now() + std::chrono::seconds{30}; }

  os::TcpConnection connect() { return os::TcpConnection::connect(server_->address(), at_last()).value(); }
  // Up to `end`, or until the server closes the connection.
  std::string receive(const os::TcpConnection& client, const std::string& end = {}) {
    std::string text;
    char buffer[4096];
    const TimePoint deadline = at_last();
    while (end.empty() || !text.ends_with(end)) {
      const auto got = client.receive(buffer, end.empty() ? sizeof buffer : 1, deadline);
      EXPECT_NE(got.outcome, Outcome::kTimedOut) << text;
      if (got.outcome != Outcome::kDone) break;
      text.append(buffer, got.bytes);
    }
    return text;
  }
  void send(const os::TcpConnection& client, const std::string& text) {
    static_cast<void>(client.send(text, at_last()));  // the server may have hung up
  }
  // The whole answer.
  std::string ask(const std::string& request) {
    const os::TcpConnection client = connect();
    send(client, request);
    return receive(client);
  }
  std::string get(const std::string& path, const std::string& host = "localhost") {
    return ask("GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  }
  std::string post(const std::string& path, const std::string& body, const std::string& headers) {
    return ask("POST " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + headers +
               "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }
  os::TcpConnection open_events() {
    os::TcpConnection client = connect();
    send(client, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_THAT(receive(client, "event: timeline"), HasSubstr("event: live"));
    return client;
  }
  // Until a client is served again.
  std::string get_once_there_is_room(const std::string& path) {
    std::string answer;
    for (const TimePoint deadline = at_last(); os_->now() < deadline;) {
      answer = get(path);
      if (!answer.starts_with("HTTP/1.1 503")) break;
      os_->sleep_until(os_->now() + milliseconds{5});
    }
    return answer;
  }

  std::unique_ptr<os::Os> os_ = os::make_linux_os();
  PlayedSource source_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<os::Thread> thread_;
};

TEST_F(WebServerTest, ServesThePageAndNothingFromElsewhere) {
  start();
  const std::string page = get("/");
  EXPECT_THAT(page, AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), HasSubstr("Content-Type: text/html; charset=utf-8\r\n"),
                          HasSubstr("<script src=\"page.js\""), HasSubstr("href=\"style.css\"")));
  EXPECT_THAT(page, AllOf(HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'"),
                          HasSubstr("X-Content-Type-Options: nosniff\r\n"), HasSubstr("Cache-Control: no-store\r\n")));
  EXPECT_THAT(page, Not(HasSubstr("//")));  // no address of another server
  EXPECT_THAT(get("/style.css"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("text/css"), HasSubstr("prefers-color")));
  EXPECT_THAT(get("/page.js"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("text/javascript"), HasSubstr("EventSource"),
                                     HasSubstr("'whatif'")));
  // Each place that the script names is in the page.
  const std::string script = get("/page.js");
  std::size_t named = 0;
  for (std::size_t at = script.find("at('"); at != std::string::npos; at = script.find("at('", at + 1)) {
    const std::string id = script.substr(at + 4, script.find('\'', at + 4) - at - 4);
    EXPECT_THAT(page, HasSubstr("id=\"" + id + "\""));
    ++named;
  }
  EXPECT_GT(named, 10U);
  const std::string head = ask("HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(head, AllOf(StartsWith("HTTP/1.1 200"), EndsWith("\r\n\r\n"), Not(HasSubstr("<script"))));
}

TEST_F(WebServerTest, ServesDocuments) {
  start();
  EXPECT_THAT(get("/live"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Type: application/json\r\n"),
                                  EndsWith("\r\n\r\n{\"app\":\"played\",\n \"up_s\":1}")));
  EXPECT_THAT(get("/live?x=1"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(get("/snapshot"), EndsWith("{\"plans\":3}"));
  EXPECT_THAT(get("/timeline"), EndsWith("{\"lanes\":[]}"));
  EXPECT_THAT(get("/control"), EndsWith("{\"allowed\":false}\n"));
  EXPECT_THAT(get("/metrics"), AllOf(HasSubstr("Content-Type: text/plain; version=0.0.4; charset=utf-8\r\n"),
                                     HasSubstr("\ncatan_up 1\n"), HasSubstr("\ncatan_plans_total 3\n")));
  EXPECT_THAT(get("/plan"),
              AllOf(StartsWith("HTTP/1.1 503"), EndsWith("{\"error\":\"there is no plan\",\"hint\":\"wait\"}\n")));
}

TEST_F(WebServerTest, ASchedulerThatIsGoneIsTold) {
  *source_.live_text.lock() = Error::environment("it has gone", "start it");
  *source_.snapshot_text.lock() = Error::environment("it has gone", "start it");
  start();
  EXPECT_THAT(get("/live"), AllOf(StartsWith("HTTP/1.1 503"), HasSubstr("it has gone")));
  EXPECT_THAT(get("/metrics"), AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("\ncatan_up 0\n")));
  const os::TcpConnection client = connect();
  send(client, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(receive(client, "start it"), HasSubstr("event: trouble"));
}

TEST_F(WebServerTest, WhatIsNotThereIsTold) {
  start();
  EXPECT_THAT(get("/none"), AllOf(StartsWith("HTTP/1.1 404"), HasSubstr("{\"error\":"), HasSubstr("nosniff")));
  EXPECT_THAT(get("/../../etc/passwd"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(get("/%2e%2e/etc/passwd%00"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(post("/live", "", ""), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(ask("DELETE /live HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              AllOf(StartsWith("HTTP/1.1 405"), HasSubstr("Allow: GET, HEAD, POST\r\n")));
}

TEST_F(WebServerTest, AConnectionCarriesSeveralRequestsAndNoMoreThanAllowed) {
  Limits limits;
  limits.requests = 3;
  start(limits);
  const os::TcpConnection client = connect();
  const std::string request = "GET /snapshot HTTP/1.1\r\nHost: localhost\r\n\r\n";
  send(client, request);
  EXPECT_THAT(receive(client, "{\"plans\":3}"), HasSubstr("\r\nKeep-Alive: timeout=5"));
  send(client, request + request + request);  // one that is too many
  const std::string rest = receive(client);
  EXPECT_THAT(rest, HasSubstr("Connection: close\r\n"));
  std::size_t answers = 0;
  for (std::size_t at = rest.find("HTTP/1.1 200"); at != std::string::npos; at = rest.find("HTTP/1.1 200", at + 1)) {
    ++answers;
  }
  EXPECT_EQ(answers, 2U);
}

TEST_F(WebServerTest, StreamsEvents) {
  Limits limits;
  limits.step = milliseconds{10};
  start(limits);
  const os::TcpConnection client = connect();
  send(client, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::string text = receive(client, "event: timeline");
  EXPECT_THAT(text, AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("Content-Type: text/event-stream\r\n"),
                          HasSubstr("retry: 2000\n\n"),
                          HasSubstr("event: live\ndata: {\"app\":\"played\",\ndata:  \"up_s\":1}\n\n")));
  *source_.live_text.lock() = std::string("{\"app\":\"another\"}");
  EXPECT_THAT(receive(client, "data: {\"app\":\"another\"}\n\n"), HasSubstr("event: live"));
  stop();
  EXPECT_THAT(receive(client), Not(HasSubstr("error")));  // and comes to its end
}

TEST_F(WebServerTest, AStreamEndsAfterItsTime) {
  Limits limits;
  limits.step = milliseconds{5};
  limits.stream = milliseconds{50};
  start(limits);
  const os::TcpConnection client = connect();
  send(client, "GET /events HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(receive(client), EndsWith("0\r\n\r\n"));
}

TEST_F(WebServerTest, TheSeventeenthClientIsToldSo) {
  start();
  std::vector<os::TcpConnection> clients;
  for (int i = 0; i < 16; ++i) clients.push_back(open_events());
  for (int i = 0; i < 100; ++i) {
    ASSERT_THAT(get("/"), AllOf(StartsWith("HTTP/1.1 503 Service Unavailable\r\n"), HasSubstr("Retry-After: 1\r\n"),
                                HasSubstr("\"error\":")));
  }
  clients.pop_back();
  EXPECT_THAT(get_once_there_is_room("/"), StartsWith("HTTP/1.1 200"));
}

TEST_F(WebServerTest, WhoIsTurnedAwayAndStaysCostsNothing) {
  Limits limits;
  limits.clients = 1;
  start(limits);
  std::optional<os::TcpConnection> served(open_events());
  std::vector<os::TcpConnection> silent;
  for (int i = 0; i < 300; ++i) silent.push_back(connect());
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 503"));
  served.reset();
  EXPECT_THAT(get_once_there_is_room("/"), StartsWith("HTTP/1.1 200"));
}

TEST_F(WebServerTest, ClientsAreCutOffThatDoNotAskInTime) {
  Limits limits;
  limits.idle = limits.request = milliseconds{100};
  start(limits);
  const os::TcpConnection silent = connect();
  EXPECT_EQ(receive(silent), "");
  const os::TcpConnection half = connect();
  send(half, "GET / HTTP/1.1\r\nHost: loc");
  EXPECT_THAT(receive(half), AllOf(StartsWith("HTTP/1.1 408"), HasSubstr("Connection: close\r\n")));
  const os::TcpConnection no_body = connect();
  send(no_body, "POST /live HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\n12345");
  receive(no_body);  // until it is closed
}

TEST_F(WebServerTest, ClientsAreCutOffThatDripOneByteAtATime) {
  Limits limits;
  limits.request = milliseconds{200};
  start(limits);
  const os::TcpConnection client = connect();
  std::string answer;
  char buffer[4096];
  for (const TimePoint deadline = at_last(); os_->now() < deadline;) {
    send(client, "a");
    const auto got = client.receive(buffer, sizeof buffer, os_->now() + milliseconds{20});
    if (got.outcome == Outcome::kDone) answer.append(buffer, got.bytes);
    if (got.outcome == Outcome::kClosed) break;
  }
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 408"));
}

TEST_F(WebServerTest, AClientThatDoesNotReadLosesItsSeat) {
  *source_.live_text.lock() = std::string(64U << 20U, 'x');  // more than the system's buffers
  Limits limits;
  limits.clients = 1;
  limits.answer = milliseconds{100};
  start(limits);
  const os::TcpConnection client = connect();
  send(client, "GET /live HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(receive(client, "HTTP/1.1 200"), "HTTP/1.1 200");
  EXPECT_THAT(get_once_there_is_room("/snapshot"), StartsWith("HTTP/1.1 200"));
}

TEST_F(WebServerTest, WhatIsTooLongOrNoRequestIsRefused) {
  start();
  const std::string begin = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_THAT(ask(begin + "A: " + std::string(20'000, 'a')), StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(ask(std::string(1'000'000, 'a')), StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(ask("GET /" + std::string(2'000, 'a') + " HTTP/1.1\r\nHost: localhost\r\n\r\n"),
              StartsWith("HTTP/1.1 414"));
  EXPECT_THAT(post("/control/change", std::string(70'000, 'a'), ""), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(post("/live", "a", "Transfer-Encoding: chunked\r\n"), StartsWith("HTTP/1.1 501"));
  EXPECT_THAT(post("/live", "a", "Content-Encoding: gzip\r\n"), StartsWith("HTTP/1.1 415"));
  EXPECT_THAT(ask("\x16\x03\x01\x02\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
}

TEST_F(WebServerTest, OtherNamesOfThisMachineAreRefused) {
  start();
  EXPECT_THAT(get("/live", "evil.example"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/live", "127.0.0.1:" + std::to_string(server_->address().port)), StartsWith("HTTP/1.1 200"));
}

TEST_F(WebServerTest, NothingIsChangedUnlessThatIsAllowed) {
  start();
  const std::string change = R"({"weights": [["0", 0.5]]})";
  EXPECT_THAT(post("/control/change", change, std::string("Authorization: Bearer ") + kToken + "\r\n"),
              AllOf(StartsWith("HTTP/1.1 403"), HasSubstr("--allow-control")));
  EXPECT_TRUE(source_.changed.lock()->empty());
}

TEST_F(WebServerTest, WhoHasTheTokenChanges) {
  start(Limits{}, kToken);
  const std::string authorization = std::string("Authorization: Bearer ") + kToken + "\r\n";
  const std::string change = R"({"weights": [["0", 0.5]]})";
  EXPECT_THAT(post("/control/change", change, ""),
              AllOf(StartsWith("HTTP/1.1 401"), HasSubstr("WWW-Authenticate: Bearer\r\n")));
  EXPECT_THAT(post("/control/change", change, "Authorization: Bearer 0123456789abcdeF\r\n"),
              StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(post("/control/change", change, authorization + "Origin: http://evil.example\r\n"),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(post("/control/change", "{\"weights\": 1}", authorization),
              AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("not understood")));
  EXPECT_TRUE(source_.changed.lock()->empty());

  EXPECT_THAT(get("/control"), EndsWith("{\"allowed\":true}\n"));
  EXPECT_THAT(post("/control/change", change, authorization + "Origin: http://localhost\r\nExpect: 100-continue\r\n"),
              AllOf(StartsWith("HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200"), EndsWith("{\"done\":true}\n")));
  EXPECT_THAT(post("/control/change", R"({"weights": [["none", 1]]})", authorization),
              AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("there is no such term"), HasSubstr("name another")));
  Changes first;
  first.weights = {{"0", 0.5}};
  Changes second;
  second.weights = {{"none", 1.0}};
  EXPECT_THAT(*source_.changed.lock(), ElementsAre(first, second));
}

TEST_F(WebServerTest, WhatIfIsAnsweredWithoutAToken) {
  start();
  EXPECT_THAT(post("/whatif", R"({"costs": {"LM": "x2"}, "cores": 3})", "Origin: http://localhost\r\n"),
              AllOf(StartsWith("HTTP/1.1 200"), HasSubstr("application/json"), EndsWith("{\"then\":1}")));
  EXPECT_THAT(post("/whatif", R"({"cores": 9})", ""),
              AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("there are no nine cores"), HasSubstr("ask for fewer")));
  EXPECT_THAT(*source_.questions.lock(),
              ElementsAre(WhatIf{{}, {{"LM", "x2"}}, 3}, WhatIf{.changes = {}, .costs = {}, .cores = 9}));
  EXPECT_TRUE(source_.changed.lock()->empty());
}

TEST_F(WebServerTest, WhatIfIsRefusedToOtherSitesAndWhereItIsNotUnderstood) {
  start();
  EXPECT_THAT(post("/whatif", "{}", "Origin: http://evil.example\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(post("/whatif", "{\"cores\": 0}", ""),
              AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("not understood"), HasSubstr("hint")));
  EXPECT_THAT(get("/whatif"), StartsWith("HTTP/1.1 404"));
  EXPECT_TRUE(source_.questions.lock()->empty());
}

TEST_F(WebServerTest, OneQuestionIsAnsweredAtATime) {
  start();
  source_.thinking = true;
  const os::TcpConnection first = connect();
  send(first, "POST /whatif HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 2\r\n\r\n{}");
  const TimePoint until = at_last();
  while (source_.questions.lock()->empty() && os_->now() < until) os_->sleep_until(os_->now() + milliseconds{1});
  EXPECT_THAT(post("/whatif", "{}", ""),
              AllOf(StartsWith("HTTP/1.1 429"), HasSubstr("Retry-After: 1\r\n"), HasSubstr("ask again")));
  EXPECT_THAT(get("/live"), StartsWith("HTTP/1.1 200")) << "what is shown goes on";
  source_.thinking = false;
  EXPECT_THAT(receive(first), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(post("/whatif", "{}", ""), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(source_.questions.lock()->size(), 2U);
}

TEST_F(WebServerTest, HoweverManyAskTheSourceIsAskedSeldom) {
  Limits limits;
  limits.step = std::chrono::hours{1};
  start(limits);
  for (int i = 0; i < 50; ++i) ASSERT_THAT(get("/live"), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(source_.asked.load(), 1);
}

TEST_F(WebServerTest, StoppingCutsAllClientsOff) {
  start();
  const os::TcpConnection events = open_events();
  const os::TcpConnection half = connect();
  send(half, "GET / HTTP/1.1\r\n");
  const os::TcpConnection silent = connect();
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));  // those before were let in
  stop();
  receive(events);
  receive(half);
  EXPECT_EQ(receive(silent), "");
}

TEST_F(WebServerTest, AnAddressInUseIsAnError) {
  start();
  const auto second = Server::open(*os_, source_, server_->address(), std::nullopt);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::web
