// An application in one process, scheduled by Catan.
//
//   auto session = ctn::Session::open("app.yaml", options);        // reads the app file, asks the machine what it
//   grants auto& frames = session->channel<Image>("camera", "detect");      // one channel an edge
//   session->node("camera", [&](ctn::Run& run) { frames.write(run, grab()); });
//   session->node("detect", [&](ctn::Run& run) { if (auto* f = frames.read(run)) look(*f); });
//   session->start();   ...   session->stop();
//
// Each scheduled node has a thread that Catan makes; its function is called once a run: a head's on its trigger,
// another's when its predecessor in the subchain has ended. What a run writes becomes visible when it ends. An
// unscheduled node's function is called once every period of the node. External nodes have none.
//
// Policies: "catan" plans rates, cores and levels from measured compute times; "default" triggers each subchain at its
// head's `fallback_rate` under ordinary scheduling; "rate:HZ" does so at a given rate. Without the permission to set
// real-time levels "catan" plans and triggers but does not prioritise (rates only), and says so in the snapshot, in the
// record and to on_notice.
//
// Thread safety: open, channel, node, start, stop from one thread; snapshot and notices from any.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "catan/channel.h"
#include "catan/result.h"
#include "catan/run.h"
#include "catan/snapshot.h"

namespace ctn {

struct SessionOptions {
  std::string policy = "catan";
  std::vector<int> cpus;                              // CPUs that nodes may use; empty: all that this process may use
  std::string record;                                 // path of the record to write; empty: none
  std::string note;                                   // kept in the record
  std::function<void(const std::string&)> on_notice;  // called from a thread at the ordinary level; may block
};

class Session {
 public:
  // Errors: all that is wrong with the file (kCaller), CPUs that are not there (kCaller), a record that cannot be made.
  static Result<Session> open(const std::string& app_file, const SessionOptions& options);

  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();  // stops

  // What `node` does in a run. Precondition (asserted): the app has such a node, not external, without a function yet.
  void node(std::string_view name, std::function<void(Run&)> body);

  // The channel of the edge from -> to, made on first use. Precondition (asserted): there is such an edge, and T is the
  // type it was made with. Lives as long as the session.
  template <class T>
  Channel<T>& channel(std::string_view from, std::string_view to) {
    const ChannelKey key = channel_key(from, to, typeid(T));
    if (ChannelBase* made = find_channel(key)) return static_cast<Channel<T>&>(*made);
    return static_cast<Channel<T>&>(
        adopt_channel(key, std::make_unique<Channel<T>>(key.producer, key.consumer, key.slot, key.queue)));
  }

  // Starts all threads. Errors: a node without a function (kCaller); a plan that cannot be made.
  Status start();
  // Ends all runs that are under way, restores scheduling, closes the record. May be called twice. The first error of
  // the record.
  Status stop();

  Snapshot snapshot() const;

 private:
  struct ChannelKey {
    std::uint32_t producer = 0;
    std::uint32_t consumer = 0;
    std::uint32_t slot = 0;  // which of the consumer's inputs
    bool queue = false;
    std::type_index type = typeid(void);
  };
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  ChannelKey channel_key(std::string_view from, std::string_view to, std::type_index type) const;
  ChannelBase* find_channel(const ChannelKey& key) const;
  ChannelBase& adopt_channel(const ChannelKey& key, std::unique_ptr<ChannelBase> channel);

  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn
