#include "web/server.h"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "os/linux/poller.h"
#include "web/conversation.h"
#include "web/routes.h"
#include "web/seats.h"
#include "web/stop_sign.h"
#include "web/turned_away.h"

namespace ctn::web {
namespace {

// Keys of the poller; those of what else is watched follow, and those of TurnedAway.
constexpr os::Poller::Key kListener = 0;
constexpr int kMaxLetInAtOnce = 64;

}  // namespace

// Lets clients in, in the thread that calls run().
struct Server::Impl {
  Impl(os::Os& os, Source& source, os::TcpListener listening, std::unique_ptr<os::Poller> waits,
       std::optional<std::string> token, const Limits& max)
      : listener(std::move(listening)),
        poller(std::move(waits)),
        limits(max),
        rules{os::is_loopback_host(listener.address().host), std::move(token)},
        stop(os),
        routes(os, source, limits, stop, rules.token.has_value(), listener.socket().number()),
        seats(os, limits.clients, stop,
              [this, &os](const os::TcpConnection& client) {
                Conversation(os, limits, rules, stop, routes, client).hold();
              }),
        turned_away(os, *poller) {}

  void run() {
    while (!stop.given()) {
      const std::vector<os::Poller::Key> ready = poller->wait(turned_away.next());
      for (const os::Poller::Key key : ready) {
        if (key == kListener) {
          let_in();
        } else if (key >= TurnedAway::kFirstKey) {
          turned_away.hear(key);
        } else if (key <= watched.size()) {
          watched[key - 1]();
        }
      }
      turned_away.drop_overdue();
    }
    end();
  }

  void let_in() {
    for (int i = 0; i < kMaxLetInAtOnce; ++i) {
      std::optional<os::TcpConnection> client = listener.accept();
      if (!client) return;
      if (!seats.take(*client)) turned_away.add(std::move(*client));
    }
  }

  void ask_to_stop() {
    stop.give();
    poller->wake();
  }

  void end() {
    routes.end();
    seats.end();
    turned_away.drop_all();
  }

  os::TcpListener listener;
  std::unique_ptr<os::Poller> poller;
  const Limits limits;
  const AccessRules rules;
  StopSign stop;
  Routes routes;
  Seats seats;
  TurnedAway turned_away;
  std::vector<std::function<void()>> watched;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  impl_->ask_to_stop();
  impl_->end();
}

Result<std::unique_ptr<Server>> Server::open(os::Os& os, Source& source, const os::TcpAddress& address,
                                             std::optional<std::string> token, const Limits& limits) {
  Result<os::TcpListener> listener = os::TcpListener::open(address);
  if (!listener) return listener.error();
  Result<std::unique_ptr<os::Poller>> poller = os::Poller::make();
  if (!poller) return poller.error();
  if (Status added = (*poller)->add(listener->socket(), kListener); !added) return added.error();
  return std::unique_ptr<Server>(new Server(
      std::make_unique<Impl>(os, source, std::move(*listener), std::move(*poller), std::move(token), limits)));
}

const os::TcpAddress& Server::address() const { return impl_->listener.address(); }

Status Server::watch(const os::Descriptor& descriptor, std::function<void()> ready) {
  impl_->watched.push_back(std::move(ready));
  return impl_->poller->add(descriptor, impl_->watched.size());
}

void Server::run() { impl_->run(); }

void Server::stop() { impl_->ask_to_stop(); }

}  // namespace ctn::web
