// With real sockets; the test itself is the server.
#include "runtime/client_link.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "os/linux/linux_os.h"
#include "os/linux/listener.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ClientLinkTest : public ::testing::Test {
 protected:
  ClientLinkTest() {
    Result<os::Listener> opened = os::Listener::open(path, 0600);
    if (opened) listener.emplace(std::move(*opened));
  }

  // The next program that connects.
  os::Connection accept_client() {
    for (;;) {
      Result<std::optional<os::Connection>> accepted = listener->accept();
      if (accepted && *accepted) return std::move(**accepted);
      std::this_thread::sleep_for(milliseconds{1});
    }
  }
  static std::string hear(const os::Connection& connection) {
    os::Message message;
    while (connection.receive(message) == os::Arrival::kNothing) std::this_thread::sleep_for(milliseconds{1});
    return message.text;
  }
  os::Connection dialled() {
    std::optional<os::Connection> connection;
    std::thread server([&] {
      connection.emplace(accept_client());
      hear(*connection);
      EXPECT_TRUE(connection->send(to_text(Status(Done{})), &memory.descriptor()).ok());
    });
    EXPECT_TRUE(link.converse()->dial(os->current_thread(), {}).ok());
    server.join();
    return std::move(*connection);
  }

  std::string path = testing::TempDir() + "catan_link_" + std::to_string(::getpid());
  std::unique_ptr<os::Os> os = os::make_linux_os();
  os::SharedMemory memory = *os::SharedMemory::create("link-test", 4096);
  std::optional<os::Listener> listener;
  ClientLink link{*os, {path}};
  Request leave{.kind = Request::Kind::kLeave, .node = "node"};
};

TEST_F(ClientLinkTest, ACallReturnsTheAnswerOfTheServer) {
  const os::Connection server = dialled();
  std::thread answering([&] {
    EXPECT_EQ(hear(server), to_text(leave));
    EXPECT_TRUE(server.send(to_text(Status(Error::caller("no", "why not")))).ok());
  });
  const Status answer = link.converse()->call(leave);
  answering.join();
  ASSERT_FALSE(answer.ok());
  EXPECT_EQ(answer.error().kind(), ErrorKind::kCaller);
}

// Guards: a late answer was taken for that to the next request.
TEST_F(ClientLinkTest, ACallWithoutAnAnswerInTimeEndsTheConnection) {
  const os::Connection server = dialled();
  const Status first = link.converse()->call(leave, [] { return std::nullopt; });
  ASSERT_FALSE(first.ok());
  EXPECT_EQ(first.error().kind(), ErrorKind::kEnvironment);
  static_cast<void>(server.send(to_text(Status(Done{}))));
  EXPECT_FALSE(link.converse()->call(leave).ok()) << "there is no connection any more";
  EXPECT_EQ(link.wait(os->now() + seconds{5}), true) << "wait() reports it";
  EXPECT_EQ(link.wait(os->now()), false) << "once";
  os::Message message;
  while (server.receive(message) == os::Arrival::kMessage) continue;
  EXPECT_EQ(server.receive(message), os::Arrival::kClosed);
}

// Guards: while one thread waited for an answer, the one that watches the server could neither notice that it was gone
// nor run nodes.
TEST_F(ClientLinkTest, WaitDoesNotBlockOnACallUnderWay) {
  std::optional<os::Connection> server = dialled();
  std::atomic<bool> asking{false};
  std::thread asks([&] {
    const std::unique_ptr<Conversation> conversation = link.converse();
    asking.store(true);
    EXPECT_FALSE(conversation->call(leave).ok());
  });
  while (!asking.load()) std::this_thread::sleep_for(milliseconds{1});
  hear(*server);
  const TimePoint begin = os->now();
  EXPECT_EQ(link.wait(begin + milliseconds{10}), false);
  link.hang_up();
  asks.join();
  EXPECT_LT(os->now() - begin, milliseconds{1500}) << "hanging up ends the waiting, which would last two seconds";
}

TEST_F(ClientLinkTest, WaitReportsOnceThatTheServerHasClosedTheConnection) {
  std::optional<os::Connection> server = dialled();
  EXPECT_EQ(link.wait(os->now()), false);
  server.reset();
  EXPECT_EQ(link.wait(os->now() + seconds{5}), true);
  EXPECT_EQ(link.wait(os->now()), false);
  EXPECT_FALSE(link.converse()->call(leave).ok());
}

TEST_F(ClientLinkTest, AMessageThatWasNotAskedForIsDropped) {
  const os::Connection server = dialled();
  ASSERT_TRUE(server.send(to_text(Status(Error::caller("unasked", "nothing")))).ok());
  EXPECT_EQ(link.wait(os->now() + milliseconds{50}), false);
  std::thread answering([&] {
    hear(server);
    EXPECT_TRUE(server.send(to_text(Status(Done{}))).ok());
  });
  EXPECT_TRUE(link.converse()->call(leave).ok());
  answering.join();
}

TEST_F(ClientLinkTest, DialFailsAtOnceWhereNoServerListens) {
  listener.reset();
  const auto dialled = link.converse()->dial(os->current_thread(), {});
  ASSERT_FALSE(dialled.ok());
  EXPECT_EQ(dialled.error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::runtime
