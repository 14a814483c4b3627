#include "common/kept_messages.h"

#include <algorithm>
#include <mutex>

namespace catan_ros {

void KeptMessages::Topic::note_made(const void* message, Key key) {
  const std::lock_guard lock(mutex_);
  made_[next_++ % kMade] = {message, key};
}

KeptMessages::Key KeptMessages::Topic::find(const void* message) const {
  const std::lock_guard lock(mutex_);
  for (std::size_t back = 1; back <= std::min(next_, kMade); ++back) {
    const Made& made = made_[(next_ - back) % kMade];
    if (made.message == message) return made.key;
  }
  return 0;
}

KeptMessages::Topic& KeptMessages::topic(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const Topic& one) { return one.name() == name; });
  return known != topics_.end() ? *known : topics_.emplace_back(name);
}

std::vector<KeptMessages::Key> KeptMessages::keys() const {
  const std::lock_guard lock(mutex_);
  std::vector<Key> keys;
  for (const Topic& one : topics_) {
    if (one.newest() != 0) keys.push_back(one.newest());
  }
  return keys;
}

}  // namespace catan_ros
