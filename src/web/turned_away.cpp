#include "web/turned_away.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <utility>

#include "web/answers.h"
#include "web/limits.h"

namespace ctn::web {

void TurnedAway::add(os::TcpConnection client) {
  static const std::string kAnswer =
      answer_of({503, "as many clients are served as can be", "close one, or try again"});
  if (client.send_now(kAnswer) < kAnswer.size()) return;
  client.finish();
  if (clients_.size() >= kMaxClients) drop(clients_.begin());
  const auto it = clients_.emplace(next_key_++, Client{std::move(client), clock_.now() + kLeaveWithin}).first;
  if (!poller_.add(it->second.connection.socket(), it->first)) clients_.erase(it);
}

void TurnedAway::hear(os::Poller::Key key) {
  const auto it = clients_.find(key);
  if (it == clients_.end()) return;
  std::array<char, 4096> buffer;
  const auto got = it->second.connection.receive(buffer.data(), buffer.size(), TimePoint{});
  it->second.heard += got.bytes;
  if (got.outcome != os::TcpConnection::Outcome::kDone || it->second.heard >= kMaxHeard) drop(it);
}

TimePoint TurnedAway::next() const {
  TimePoint next = kNever;
  for (const auto& [key, client] : clients_) next = std::min(next, client.until);
  return next;
}

void TurnedAway::drop_overdue() {
  const TimePoint now = clock_.now();
  for (auto it = clients_.begin(); it != clients_.end();) it = it->second.until <= now ? drop(it) : std::next(it);
}

void TurnedAway::drop_all() {
  while (!clients_.empty()) drop(clients_.begin());
}

TurnedAway::Clients::iterator TurnedAway::drop(Clients::iterator client) {
  poller_.remove(client->second.connection.socket());
  return clients_.erase(client);
}

}  // namespace ctn::web
