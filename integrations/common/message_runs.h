// Which run of a node sent a message: how the lineage of data is known across programs, though messages do not carry
// it.
//
// A node that publishes notes the key of the message, which is made of its bytes, and the number of its run; who gets
// the message makes the same key and finds the run. (A sequence number would have to be in the message: some have none,
// a publisher counts in one way and its connections in another, and both drop messages.) Messages with the same bytes
// have the same key, and the newest counts.
//
// All is in a file that the programs of an app share: for each of at most kNodes nodes the last messages, so many that
// one is still known when it is taken seconds later, among those of a node that sends a hundred in a second. They lie
// in kSets sets by their keys, each with the last kMessagesOfASet of its own, so that few have to be looked at. Where
// the file cannot be opened there is no lineage of this kind, and a run counts as having taken the newest output.
//
// It also says when a node last sent on a topic, so that who is triggered for that message knows that it is under way,
// and which topics the program of a node subscribes, which whoever publishes on them has to know: a run gives
// output if somebody who comes next takes it (binding.h).
//
// Thread safety: all calls from any thread; wait-free. What another program wrote is not trusted: at worst a run is not
// found, or a wrong one is.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "common/shared_file.h"

namespace catan_ros {

class MessageRuns {
 public:
  static constexpr std::size_t kNodes = kSharedNodes;
  static constexpr std::size_t kSets = 256;
  static constexpr std::size_t kMessagesOfASet = 8;
  static constexpr std::size_t kSubscriptions = 4096;
  static constexpr std::size_t kSenders = 1024;
  using Key = std::uint64_t;

  // Makes the file if it is not there. Null: it cannot be had, or is not this user's.
  static std::unique_ptr<MessageRuns> open(const std::string& path);
  // For one program alone, without a file. Null: there is no memory.
  static std::unique_ptr<MessageRuns> make();

  // Of a message on a topic: its first and last bytes and its length.
  static Key key_of(std::string_view topic, std::span<const std::byte> message);
  // Of one that goes to others of the same program as it is, by where it lies.
  static Key key_of_address(std::string_view topic, const void* message);

  void note(std::string_view node, Key key, std::uint64_t run);
  // The newest run of `node` that sent such a message; 0: none that is known.
  std::uint64_t find(std::string_view node, Key key) const;

  // When the node last sent on the topic (or is about to), by the monotonic clock; none: never. Beyond kSenders that is
  // not known.
  using Time = std::chrono::steady_clock::time_point;
  void note_time(std::string_view node, std::string_view topic, Time time);
  std::optional<Time> last_time(std::string_view node, std::string_view topic) const;

  // The program of `node` subscribes the topic, and so may keep what comes on it for the node. Beyond kSubscriptions
  // they are not noted.
  void note_subscription(std::string_view node, std::string_view topic);
  bool subscribes(std::string_view node, std::string_view topic) const;

 private:
  struct Message {
    std::atomic<Key> key{0};
    std::atomic<std::uint64_t> run{0};
  };
  struct Node {
    std::atomic<std::uint64_t> hash{0};  // of its name
    std::array<std::array<Message, kMessagesOfASet>, kSets> sets{};
  };
  struct Sender {
    std::atomic<std::uint64_t> hash{0};  // of node and topic
    std::atomic<std::int64_t> time{0};
  };
  struct Subscription {
    std::atomic<std::uint64_t> hash{0};  // of node and topic
  };
  struct Tables {
    std::array<Sender, kSenders> senders{};
    std::array<Subscription, kSubscriptions> subscriptions{};
    std::array<Node, kNodes> nodes{};
  };

  explicit MessageRuns(std::unique_ptr<SharedFile<Tables>> file) : file_(std::move(file)) {}

  std::unique_ptr<SharedFile<Tables>> file_;
};

}  // namespace catan_ros
