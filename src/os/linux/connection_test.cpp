// Connections and the listener that makes them, with clients that mean well and others.
#include "os/linux/connection.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "os/linux/files.h"
#include "os/linux/forked_process.h"
#include "os/linux/linux_os.h"
#include "os/linux/listener.h"
#include "os/linux/poller.h"
#include "os/linux/shared_memory.h"
#include "os/testing/conformance.h"
#include "os/testing/requires_real_time.h"

namespace ctn::os {
namespace {

using namespace std::chrono_literals;
using conformance::kTimeout;
using testing::HasSubstr;

std::size_t open_descriptors() {
  const auto numbers = numbered_entries("/proc/self/fd", "");
  return numbers ? numbers->size() : 0;
}

class LocalSocket : public testing::Test {
 protected:
  LocalSocket() {
    std::string name = (std::filesystem::temp_directory_path() / "catan-socket-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    ::chmod(folder_.c_str(), 0755);
    path_ = folder_ + "/app";
  }
  ~LocalSocket() override { std::filesystem::remove_all(folder_); }

  void listen(unsigned mode = 0666) {
    auto made = Listener::open(path_, mode);
    ASSERT_TRUE(made.ok()) << made.error().message();
    listener_.emplace(std::move(*made));
  }

  // Waits for a client, or for its message.
  Connection accept_client() {
    wait_for(listener_->socket());
    auto found = listener_->accept();
    EXPECT_TRUE(found.ok() && found->has_value());
    return std::move(**found);
  }
  Arrival receive(const Connection& from, Message& message) {
    wait_for(from.socket());
    return from.receive(message);
  }
  void wait_for(const Descriptor& descriptor) {
    ASSERT_TRUE(poller_->add(descriptor, 1).ok());
    EXPECT_THAT(poller_->wait(os_->now() + kTimeout), testing::ElementsAre(1));
    poller_->remove(descriptor);
  }

  std::unique_ptr<Os> os_ = make_linux_os();
  std::unique_ptr<Poller> poller_ = Poller::make().value();
  std::string folder_;
  std::string path_;
  std::optional<Listener> listener_;
};

// A connection as a client sees it that keeps to no rules.
Descriptor raw_connection(const std::string& path) {
  Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  EXPECT_EQ(::connect(socket.number(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return socket;
}

ssize_t send_descriptors(const Descriptor& socket, std::size_t count, std::string text) {
  std::vector<int> numbers(count, STDIN_FILENO);
  std::vector<char> control(CMSG_SPACE(count * sizeof(int)));
  iovec part{text.data(), text.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(count * sizeof(int));
  std::memcpy(CMSG_DATA(header), numbers.data(), count * sizeof(int));
  return ::sendmsg(socket.number(), &message, MSG_NOSIGNAL);
}

// ---- Messages

TEST_F(LocalSocket, MessagesArriveWholeBothWays) {
  listen();
  EXPECT_FALSE(listener_->accept()->has_value());
  const auto client = Connection::connect(path_);
  ASSERT_TRUE(client.ok()) << client.error().message();
  const Connection server = accept_client();
  Message message;
  EXPECT_EQ(server.receive(message), Arrival::kNothing);
  ASSERT_TRUE(client->send("first").ok());
  ASSERT_TRUE(client->send(std::string(kMaxMessage, 'x')).ok());
  ASSERT_TRUE(server.send(std::string_view("zero\0in it", 10)).ok());
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_EQ(message.text, "first");
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_EQ(message.text, std::string(kMaxMessage, 'x'));
  EXPECT_FALSE(message.truncated || message.surplus || message.descriptor.valid());
  EXPECT_EQ(server.receive(message), Arrival::kNothing);
  EXPECT_EQ(message.text, "");
  EXPECT_EQ(client->receive(message), Arrival::kMessage);
  EXPECT_EQ(message.text, std::string("zero\0in it", 10));
}

TEST_F(LocalSocket, BothEndsKnowWhoTheOtherIs) {
  listen();
  ForkedProcess child([&] {
    const auto client = Connection::connect(path_);
    Message message;
    while (client->receive(message) == Arrival::kNothing) ::usleep(1000);
    const bool right = client->peer().process == ProcessId{::getppid()} && message.sender == client->peer();
    return client->process().valid() && right ? 0 : 1;
  });
  const Connection server = accept_client();
  EXPECT_EQ(server.peer(), (Peer{child.process(), ::getuid(), ::getgid()}));
  ASSERT_TRUE(server.send("hello").ok());
  EXPECT_EQ(child.join(), 0);
}

TEST_F(LocalSocket, EachMessageNamesItsSender) {
  listen();
  ForkedProcess child([&] {
    const auto client = Connection::connect(path_);
    ForkedProcess grandchild([&] { return client->send("from the grandchild").ok() ? 0 : 1; });
    return grandchild.join() + (client->send("from the child").ok() ? 0 : 1);
  });
  const Connection server = accept_client();
  Message message;
  ASSERT_EQ(receive(server, message), Arrival::kMessage);
  EXPECT_EQ(message.text, "from the grandchild");
  EXPECT_NE(message.sender.process, child.process());
  EXPECT_NE(message.sender.process, ProcessId{0});
  ASSERT_EQ(receive(server, message), Arrival::kMessage);
  EXPECT_EQ(message.sender, server.peer());
  EXPECT_EQ(child.join(), 0);
}

TEST_F(LocalSocket, SharedMemoryIsHandedOver) {
  listen();
  const auto memory = SharedMemory::create("catan-test", 4096);
  ASSERT_TRUE(memory.ok());
  const auto client = Connection::connect(path_);
  const Connection server = accept_client();
  ASSERT_TRUE(server.send("region", &memory->descriptor()).ok());
  Message message;
  ASSERT_EQ(client->receive(message), Arrival::kMessage);
  EXPECT_FALSE(message.surplus);
  EXPECT_NE(::fcntl(message.descriptor.number(), F_GETFD) & FD_CLOEXEC, 0);
  const auto opened = SharedMemory::open(std::move(message.descriptor), 4096);
  ASSERT_TRUE(opened.ok()) << opened.error().message();
  memory->bytes()[7] = std::byte{9};
  EXPECT_EQ(opened->bytes()[7], std::byte{9});
}

TEST_F(LocalSocket, TheEndIsToldAfterTheLastMessage) {
  listen();
  std::optional<Connection> client = *Connection::connect(path_);
  const Connection server = accept_client();
  ASSERT_TRUE(client->send("last").ok());
  client.reset();
  Message message;
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_EQ(server.receive(message), Arrival::kClosed);
  EXPECT_EQ(server.receive(message), Arrival::kClosed);
  const Status sent = server.send("too late");
  ASSERT_FALSE(sent.ok());
  EXPECT_THAT(sent.error().message(), HasSubstr("closed the connection"));
}

TEST_F(LocalSocket, MessagesOfNoOrTooManyBytesAreTheCallersMistake) {
  listen();
  const auto client = Connection::connect(path_);
  EXPECT_EQ(client->send("").error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(client->send(std::string(kMaxMessage + 1, 'x')).error().kind(), ErrorKind::kCaller);
}

// ---- Clients that mean no good

TEST_F(LocalSocket, WhoDoesNotReadBlocksNobody) {
  listen();
  const auto client = Connection::connect(path_);
  const Connection server = accept_client();
  Status sent = Done{};
  int count = 0;
  while (sent.ok() && count < 100'000) {
    sent = server.send(std::string(kMaxMessage, 'x'));
    ++count;
  }
  ASSERT_FALSE(sent.ok());
  EXPECT_EQ(sent.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(sent.error().message(), HasSubstr("does not read"));
}

TEST_F(LocalSocket, TenThousandMessagesArriveInOrder) {
  constexpr int kCount = 10'000;
  listen();
  std::thread flood([&] {
    const Descriptor client = raw_connection(path_);
    for (int i = 0; i < kCount; ++i) EXPECT_EQ(::send(client.number(), &i, sizeof i, 0), static_cast<int>(sizeof i));
  });
  const Connection server = accept_client();
  Message message;
  for (int i = 0; i < kCount; ++i) {
    ASSERT_EQ(receive(server, message), Arrival::kMessage);
    int number = -1;
    ASSERT_EQ(message.text.size(), sizeof number);
    std::memcpy(&number, message.text.data(), sizeof number);
    ASSERT_EQ(number, i);
  }
  EXPECT_EQ(receive(server, message), Arrival::kClosed);
  flood.join();
}

TEST_F(LocalSocket, EmptyMessageIsNotTheEnd) {
  listen();
  const Descriptor client = raw_connection(path_);
  const Connection server = accept_client();
  ASSERT_EQ(::send(client.number(), "", 0, 0), 0);
  ASSERT_EQ(::send(client.number(), "x", 1, 0), 1);
  Message message;
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_EQ(message.text, "");
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_EQ(message.text, "x");
}

TEST_F(LocalSocket, TooLongAMessageIsReportedAsSuch) {
  listen();
  const Descriptor client = raw_connection(path_);
  const Connection server = accept_client();
  const std::string longer(kMaxMessage + 1, 'x');
  ASSERT_EQ(::send(client.number(), longer.data(), longer.size(), 0), static_cast<ssize_t>(longer.size()));
  ASSERT_EQ(::send(client.number(), "next", 4, 0), 4);
  Message message;
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_TRUE(message.truncated);
  EXPECT_EQ(message.text.size(), kMaxMessage);
  EXPECT_EQ(server.receive(message), Arrival::kMessage);
  EXPECT_FALSE(message.truncated);
  EXPECT_EQ(message.text, "next");
}

TEST_F(LocalSocket, SurplusDescriptorsAreClosed) {
  listen();
  const Descriptor client = raw_connection(path_);
  const Connection server = accept_client();
  const std::size_t before = open_descriptors();
  for (const std::size_t count : {250U, 2U, 3U, 1U}) {
    ASSERT_EQ(send_descriptors(client, count, "x"), 1) << count;
    Message message;
    ASSERT_EQ(server.receive(message), Arrival::kMessage);
    EXPECT_EQ(message.surplus, count > 1);
    EXPECT_TRUE(message.descriptor.valid());
    EXPECT_EQ(open_descriptors(), before + 1);
    EXPECT_EQ(server.receive(message), Arrival::kNothing);  // the next call releases it
    EXPECT_EQ(open_descriptors(), before);
  }
}

TEST_F(LocalSocket, DeathIsNoticedEvenIfAChildKeepsTheSocket) {
  listen();
  const SyncPipe pid_of_keeper;
  ForkedProcess client([&] {
    const auto connection = Connection::connect(path_);
    const pid_t keeper = ::fork();
    if (keeper == 0) return ::pause();
    pid_of_keeper.send(keeper);
    return ::pause();
  });
  const Connection server = accept_client();
  const auto keeper = pid_of_keeper.receive();
  ASSERT_TRUE(keeper.has_value());
  CATAN_REQUIRE(server.process().valid(), "needs a kernel with pidfd_open (Linux 5.3)");
  ASSERT_TRUE(poller_->add(server.process(), 2).ok());
  EXPECT_THAT(poller_->wait(os_->now() + 2ms), testing::IsEmpty());
  client.end(SIGKILL);
  EXPECT_THAT(poller_->wait(os_->now() + kTimeout), testing::ElementsAre(2));
  Message message;
  EXPECT_EQ(server.receive(message), Arrival::kNothing);
  ::kill(*keeper, SIGKILL);
}

TEST_F(LocalSocket, WhoIsGoneBeforeBeingLetInDoesNoHarm) {
  listen();
  ForkedProcess client([&] { return Connection::connect(path_).ok() ? 0 : 1; });
  EXPECT_EQ(client.join(), 0);
  const auto found = listener_->accept();
  ASSERT_TRUE(found.ok()) << found.error().message();
  if (*found) {  // on kernels that still know who it was
    Message message;
    EXPECT_EQ((*found)->receive(message), Arrival::kClosed);
  }
  EXPECT_FALSE(listener_->accept()->has_value());
}

// ---- Paths: both sides

TEST_F(LocalSocket, PathsThatNoSocketCanHaveAreTheCallersMistake) {
  const std::string longest = folder_ + '/' + std::string(107 - folder_.size() - 1, 'x');
  for (const std::string& path : {std::string(), longest + 'x', std::string(5000, '/'), path_ + '\0' + "x"}) {
    const auto listener = Listener::open(path, 0600);
    const auto connection = Connection::connect(path);
    ASSERT_FALSE(listener.ok() || connection.ok()) << path;
    EXPECT_EQ(listener.error().kind(), ErrorKind::kCaller);
    EXPECT_EQ(connection.error().kind(), ErrorKind::kCaller);
  }
  EXPECT_TRUE(Listener::open(longest, 0600).ok());
}

TEST_F(LocalSocket, ConnectingToNobodySaysWhatToDo) {
  const auto none = Connection::connect(path_);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(none.error().message(), testing::AllOf(HasSubstr("none is running"), HasSubstr("catan serve")));
}

TEST_F(LocalSocket, WhoMayNotConnectIsTold) {
  CATAN_REQUIRE(::getuid() == 0, "needs root, to become another user: run it as root");
  listen(0600);
  const std::size_t before = open_descriptors();
  ForkedProcess stranger([&] {
    if (!become_nobody()) return 2;
    const auto refused = Connection::connect(path_);
    return !refused.ok() && refused.error().message().find("not permitted") != std::string::npos ? 0 : 1;
  });
  EXPECT_EQ(stranger.join(), 0);
  EXPECT_EQ(open_descriptors(), before);
}

}  // namespace
}  // namespace ctn::os
