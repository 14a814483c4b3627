#include "common/server_connection.h"

#include <thread>
#include <utility>

namespace catan_ros {
namespace {

constexpr double kConnectSeconds = 0.2;

}  // namespace

ctn::Client* ServerConnection::client(const std::atomic<bool>& stop) {
  while (!stop.load() && !stopped_.load()) {
    {
      const std::lock_guard lock(mutex_);
      if (client_) return &*client_;
      if (refused_) return nullptr;
      ctn::ClientOptions options;
      options.wait_seconds = kConnectSeconds;
      options.on_notice = [tell = tell_](const std::string& text) { tell(Severity::kWarning, text); };
      ctn::Result<ctn::Client> connected = ctn::Client::connect(options);
      if (connected) {
        const ctn::Status started = connected->start();
        if (started) {
          client_.emplace(std::move(*connected));
          tell_shared();
          return &*client_;
        }
        tell_(Severity::kError, started.error().message());
        refused_ = true;
        return nullptr;
      }
      if (connected.error().kind() == ctn::ErrorKind::kCaller) {
        tell_(Severity::kError, "this program is not scheduled: " + connected.error().message());
        refused_ = true;
        return nullptr;
      }
    }
    std::this_thread::sleep_for(kTryAgain);
  }
  return nullptr;
}

std::optional<ctn::AttachedNode> ServerConnection::try_attach(const std::string& node, Tries& tries) {
  if (!there_.load()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (stopped_.load()) return std::nullopt;
  const ctn::Result<ctn::AttachedNode> attached = client_->attach(node);
  if (attached) return *attached;
  if (attached.error().kind() == ctn::ErrorKind::kCaller && !std::exchange(tries.refused, true)) {
    tell_(Severity::kError, "node " + node + " is not scheduled: " + attached.error().message() +
                                "; it goes on as without Catan, and tries again each second");
  }
  return std::nullopt;
}

std::optional<ctn::AttachedNode> ServerConnection::attach(const std::string& node, const std::atomic<bool>& stop,
                                                          const std::function<void()>& on_refused) {
  Tries tries;
  bool told = false;
  while (!stop.load() && client(stop) != nullptr) {
    if (std::optional<ctn::AttachedNode> attached = try_attach(node, tries)) return attached;
    if (tries.refused && !std::exchange(told, true)) on_refused();
    const auto until = std::chrono::steady_clock::now() + (tries.refused ? kTryAgainWhenRefused : kTryAgain);
    while (!stop.load() && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(kTryAgain);
  }
  return std::nullopt;
}

void ServerConnection::adopt_this_thread(const std::string& node) {
  const std::lock_guard lock(mutex_);
  if (!client_ || stopped_.load()) return;
  const ctn::Status adopted = client_->adopt_this_thread(node);
  if (!adopted) tell_(Severity::kWarning, "a thread of node " + node + ": " + adopted.error().message());
}

// Never waits for a server: the thread that is named may be the caller, at its beginning.
void ServerConnection::share_thread(int thread) {
  const std::lock_guard lock(shared_mutex_);
  if (there_.load()) {
    static_cast<void>(client_->share_thread(thread));
  } else {
    shared_.push_back(thread);
  }
}

// Precondition: client_ is there, which stays. One that has ended meanwhile is refused, which is as well.
void ServerConnection::tell_shared() {
  const std::lock_guard lock(shared_mutex_);
  there_.store(true);
  for (const int thread : std::exchange(shared_, {})) static_cast<void>(client_->share_thread(thread));
}

void ServerConnection::stop() {
  stopped_.store(true);
  const std::lock_guard lock(mutex_);
  if (client_) client_->stop();
}

}  // namespace catan_ros
