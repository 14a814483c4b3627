// The messages that a program has got: their keys (message_runs.h), and of each topic the newest.
//
// A message is made once where several subscriptions of a program take it, and handled by each; so its key is kept from
// when it is made to when it is handled, by where it lies. And a run may use more than the message that it is called
// with: what callbacks have kept before, as those of a synchronizer of message_filters do. So where a run got no
// message of a predecessor, it counts as having taken the newest that the program had when it began.
//
// Thread safety: all calls from any thread. Mutexes are held for a few instructions, and have priority inheritance.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "common/message_runs.h"
#include "common/priority_mutex.h"

namespace catan_ros {

class KeptMessages {
 public:
  using Key = MessageRuns::Key;

  class Topic {
   public:
    explicit Topic(std::string name) : name_(std::move(name)) {}

    const std::string& name() const { return name_; }
    // The message that lies there has that key.
    void note_made(const void* message, Key key);
    // Of the newest one that lies there; 0: not made by note_made(), or too long ago.
    Key find(const void* message) const;
    // A callback is called with such a message.
    void keep(Key key) { newest_.store(key, std::memory_order_release); }
    Key newest() const { return newest_.load(std::memory_order_acquire); }
    // Subscriptions of the program that take it.
    void add_subscriptions(int count) { subscriptions_.fetch_add(count, std::memory_order_acq_rel); }
    int subscriptions() const { return subscriptions_.load(std::memory_order_acquire); }

   private:
    struct Made {
      const void* message = nullptr;
      Key key = 0;
    };
    static constexpr std::size_t kMade = 16;

    const std::string name_;
    mutable PriorityMutex mutex_;
    std::array<Made, kMade> made_{};
    std::size_t next_ = 0;
    std::atomic<Key> newest_{0};
    std::atomic<int> subscriptions_{0};
  };

  // The same for all subscriptions of it; as good as this object.
  Topic& topic(const std::string& name);
  // The newest of each topic of which there is one.
  std::vector<Key> keys() const;

 private:
  mutable PriorityMutex mutex_;
  std::deque<Topic> topics_;
};

}  // namespace catan_ros
