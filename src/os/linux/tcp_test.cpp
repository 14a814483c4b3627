#include "os/linux/tcp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "os/linux/linux_os.h"

namespace ctn::os {
namespace {

using testing::HasSubstr;
using Outcome = TcpConnection::Outcome;

TEST(TcpAddressText, IsAPortOrANumericAddressAndAPort) {
  EXPECT_EQ(*parse_tcp_address("8080"), (TcpAddress{"127.0.0.1", 8080}));
  EXPECT_EQ(*parse_tcp_address("localhost:0"), (TcpAddress{"127.0.0.1", 0}));
  EXPECT_EQ(*parse_tcp_address("192.168.0.7:80"), (TcpAddress{"192.168.0.7", 80}));
  EXPECT_EQ(*parse_tcp_address("[::1]:65535"), (TcpAddress{"::1", 65535}));
  EXPECT_EQ(*parse_tcp_address("[fe80::1:2]:1"), (TcpAddress{"fe80::1:2", 1}));
  EXPECT_EQ(to_string(TcpAddress{"::1", 80}), "[::1]:80");
  EXPECT_EQ(to_string(TcpAddress{"127.0.0.1", 80}), "127.0.0.1:80");
}

TEST(TcpAddressText, IsNothingElse) {
  for (const std::string text : {"",
                                 ":",
                                 "80:",
                                 ":80",
                                 "a",
                                 "65536",
                                 "-1",
                                 "+1",
                                 " 80",
                                 "80 ",
                                 "1.2.3:80",
                                 "1.2.3.4.5:80",
                                 "::1:80",
                                 "[::1]",
                                 "[::1:80",
                                 "[127.0.0.1]:80",
                                 "[]:80",
                                 "example.org:80",
                                 "http://127.0.0.1:80",
                                 "127.0.0.1:80/",
                                 "1.2.3.4:0x50"}) {
    const auto address = parse_tcp_address(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_EQ(address.error().kind(), ErrorKind::kCaller) << text;
    EXPECT_THAT(address.error().message(), HasSubstr("127.0.0.1:8080")) << text;
  }
  EXPECT_FALSE(parse_tcp_address(std::string("127.0.0.1\0x:80", 14)).ok());
}

TEST(TcpAddressText, TellsWhatOnlyThisMachineReaches) {
  for (const char* host : {"127.0.0.1", "127.255.0.3", "::1"}) EXPECT_TRUE(is_loopback_host(host)) << host;
  for (const char* host : {"0.0.0.0", "128.0.0.1", "::", "::2", "localhost", "", "127.0.0.1.example.org"}) {
    EXPECT_FALSE(is_loopback_host(host)) << host;
  }
  EXPECT_TRUE(is_numeric_host("10.0.0.1"));
  EXPECT_FALSE(is_numeric_host("localhost"));
}

class TcpTest : public testing::Test {
 protected:
  TimePoint in_ms(int ms) { return os_->now() + std::chrono::milliseconds{ms}; }
  TcpConnection connect(const TcpListener& listener) {
    return TcpConnection::connect(listener.address(), in_ms(5000)).value();
  }

  std::unique_ptr<Os> os_ = make_linux_os();
  TcpListener listener_ = TcpListener::open({"127.0.0.1", 0}).value();
};

TEST_F(TcpTest, ChoosesAPortAndLetsClientsIn) {
  EXPECT_NE(listener_.address().port, 0);
  EXPECT_FALSE(listener_.accept().has_value());
  const TcpConnection client = connect(listener_);
  const auto served = listener_.accept();
  ASSERT_TRUE(served.has_value());
  EXPECT_EQ(client.send("ping", in_ms(5000)), Outcome::kDone);
  char text[16];
  const auto got = served->receive(text, sizeof text, in_ms(5000));
  ASSERT_EQ(got.outcome, Outcome::kDone);
  EXPECT_EQ(std::string(text, got.bytes), "ping");
  EXPECT_FALSE(served->hung_up());
  client.finish();
  EXPECT_EQ(served->receive(text, sizeof text, in_ms(5000)).outcome, Outcome::kClosed);
  EXPECT_TRUE(served->hung_up());
  // What is finished in one direction goes on in the other.
  EXPECT_EQ(served->send("pong", in_ms(5000)), Outcome::kDone);
  EXPECT_EQ(client.receive(text, sizeof text, in_ms(5000)).bytes, 4U);
}

TEST_F(TcpTest, NothingIsWaitedForLongerThanAsked) {
  const TcpConnection client = connect(listener_);
  const auto served = listener_.accept();
  ASSERT_TRUE(served.has_value());
  char text[16];
  const TimePoint deadline = in_ms(20);
  EXPECT_EQ(served->receive(text, sizeof text, deadline).outcome, Outcome::kTimedOut);
  EXPECT_GE(os_->now(), deadline);
  EXPECT_EQ(served->receive(text, sizeof text, TimePoint{}).outcome, Outcome::kTimedOut);
  const std::string more_than_any_buffer(64U << 20U, 'x');
  EXPECT_EQ(served->send(more_than_any_buffer, in_ms(20)), Outcome::kTimedOut);
  EXPECT_LT(served->send_now(more_than_any_buffer), more_than_any_buffer.size());
}

TEST_F(TcpTest, WhoWaitsIsWokenByCuttingTheConnection) {
  const TcpConnection client = connect(listener_);
  const auto served = listener_.accept();
  ASSERT_TRUE(served.has_value());
  const auto thread = os_->spawn("cuts", [&] { served->cut(); });
  char text[16];
  EXPECT_EQ(served->receive(text, sizeof text, kNever).outcome, Outcome::kClosed);
  EXPECT_EQ(client.receive(text, sizeof text, in_ms(5000)).outcome, Outcome::kClosed);
}

TEST_F(TcpTest, AnAddressInUseIsToldWithWhatToDo) {
  const auto second = TcpListener::open(listener_.address());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(second.error().message(), HasSubstr("another program does"));
  const auto elsewhere = TcpListener::open({"192.0.2.1", 0});  // of no machine
  ASSERT_FALSE(elsewhere.ok());
  EXPECT_THAT(elsewhere.error().message(), HasSubstr("no address of this machine"));
  EXPECT_EQ(TcpListener::open({"localhost", 0}).error().kind(), ErrorKind::kCaller);
}

TEST_F(TcpTest, NoServerIsAnError) {
  const TcpAddress address = listener_.address();
  { const TcpListener closed = std::move(listener_); }
  const auto client = TcpConnection::connect(address, in_ms(5000));
  ASSERT_FALSE(client.ok());
  EXPECT_EQ(client.error().kind(), ErrorKind::kEnvironment);
}

}  // namespace
}  // namespace ctn::os
