// Which of several servers is asked, with real sockets; the test itself is the servers.
#include "runtime/control.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "os/linux/linux_os.h"
#include "os/linux/listener.h"
#include "runtime/protocol.h"

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

// Answers the question which app it has, and grants every change.
class AnsweringServer {
 public:
  AnsweringServer(const std::string& name, std::string says)
      : path(testing::TempDir() + "catan_control_" + name + "_" + std::to_string(::getpid())), says_(std::move(says)) {
    Result<os::Listener> opened = os::Listener::open(path, 0600);
    EXPECT_TRUE(opened.ok());
    listener_.emplace(std::move(*opened));
    thread_ = std::thread([this] { answer(); });
  }
  ~AnsweringServer() {
    stopping_.store(true);
    thread_.join();
  }

  const std::string path;
  std::atomic<int> changes{0};

 private:
  void answer() {
    std::vector<os::Connection> clients;
    while (!stopping_.load()) {
      if (Result<std::optional<os::Connection>> accepted = listener_->accept(); accepted && *accepted) {
        clients.push_back(std::move(**accepted));
      }
      for (const os::Connection& client : clients) {
        os::Message message;
        if (client.receive(message) != os::Arrival::kMessage) continue;
        const Result<Request> request = parse_request(message.text);
        const bool asks = request && request->kind == Request::Kind::kApp;
        if (!asks) ++changes;
        EXPECT_TRUE(client.send(asks ? says_ : to_text(Status(Done{}))).ok());
      }
      std::this_thread::sleep_for(milliseconds{1});
    }
  }

  std::string says_;
  std::optional<os::Listener> listener_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

const std::string kRefusal = to_text(Status(Error::caller("only root may control it", "run this as root")));

// Guards: a server of another user, at the socket that CATAN_SOCKET names, hid the app's own.
TEST(Control, AServerThatDoesNotSayWhichAppItHasIsPassedOver) {
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  AnsweringServer of_another_user("refuses", kRefusal);
  AnsweringServer meant("meant", app_reply("robot"));
  const Status changed = ask_to_change(*os, {{of_another_user.path, meant.path}, "robot"}, {});
  EXPECT_TRUE(changed.ok()) << changed.error().message();
  EXPECT_EQ(meant.changes, 1);
  EXPECT_EQ(of_another_user.changes, 0);
}

TEST(Control, WhereNoOtherIsFoundOneIsToldOfIt) {
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  AnsweringServer of_another_user("refuses", kRefusal);
  AnsweringServer of_another_app("other", app_reply("arm"));
  const Status changed =
      ask_to_change(*os, {{of_another_user.path, of_another_app.path, "/nowhere/catan.sock"}, "robot"}, {});
  ASSERT_FALSE(changed.ok());
  EXPECT_EQ(changed.error().kind(), ErrorKind::kEnvironment);
  const std::string message = changed.error().message();
  EXPECT_THAT(message, HasSubstr("no server answers for 'robot' at"));
  EXPECT_THAT(message, HasSubstr("the one at " + of_another_user.path +
                                 " does not say what it schedules: only root may control it"));
  EXPECT_THAT(message, HasSubstr("the one at " + of_another_app.path + " schedules 'arm'"));
  EXPECT_THAT(message, Not(HasSubstr("the one at /nowhere")));
}

TEST(Control, TheOnlyServerThatIsNamedSaysItself) {
  const std::unique_ptr<os::Os> os = os::make_linux_os();
  AnsweringServer of_another_user("refuses", kRefusal);
  const Status changed = ask_to_change(*os, {{of_another_user.path}, "robot"}, {});
  ASSERT_FALSE(changed.ok());
  EXPECT_EQ(changed.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(changed.error().message(), HasSubstr("only root may control it"));
  EXPECT_THAT(changed.error().message(), Not(HasSubstr("no server answers")));
}

}  // namespace
}  // namespace ctn::runtime
