// A load in place of an app's code: one function a node that burns the CPU time that the cost file's distribution draws
// for the run, takes its inputs and gives an output, as code of its own would.
//
// A run of a queue node burns what each item that it takes adds, too; of what other programs give, each run counts as
// an item, whether it gave an output or not.
//
// A run burns in the CPU time of the node's own thread: pre-empted, it takes longer but costs the same. Where the node
// has `max_threads`, and the plan gives it more than one, others (workers.h) burn as much at the same time. Where its
// runs wait, its own thread sleeps so long when it has burnt half.
//
// Thread safety: attach and begin from the session's thread, before it starts; add_threads from it, after; stop from
// any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "catan/client.h"
#include "catan/session.h"
#include "graph/app.h"
#include "model/workload.h"
#include "os/os.h"

namespace ctn::tool {

class SyntheticLoad {
 public:
  // `app` and `os` outlive it.
  SyntheticLoad(const graph::App& app, model::Workload work, std::uint64_t seed, os::Os& os);
  ~SyntheticLoad();

  // Gives every node its function and opens a channel for every edge. The load outlives the session.
  void attach(Session& session);
  void attach(Client& client);
  // The same for these nodes only. What others' nodes give arrives without content.
  void attach(Client& client, const std::vector<NodeId>& nodes);
  // Growth counts from now on.
  void begin();
  // Makes the threads with which nodes work that may use several. `host`: the session or client, which has started.
  template <class Host>
  Status add_threads(Host& host);
  // The session is about to stop: what runs a second from now is cut short, and gives no output.
  void stop();

 private:
  struct Node;
  std::vector<NodeId> all_nodes() const;
  // To a session or a client.
  template <class Host>
  void attach_to(Host& host, const std::vector<NodeId>& nodes);
  void run(Node& node, Run& run);
  // Whether it could burn all of it.
  bool burn(Nanos until_cpu_time) const;
  // Whether it could sleep for all of it.
  bool sleep(Nanos wait);
  bool cut_short() const;

  const graph::App& app_;
  model::Workload work_;
  std::uint64_t seed_;
  os::Os& os_;
  TimePoint begun_{};
  std::atomic<TimePoint> stop_by_{kNever};
  std::atomic<std::uint32_t> stopping_{0};  // 1 from stop() on: wakes threads that sleep
  std::vector<std::unique_ptr<Node>> nodes_;
};

// When a node with an `output_period` gives one: at its first run, and then on average once a period, as long as it
// runs at least that often. Pure.
class OutputClock {
 public:
  explicit OutputClock(std::optional<Nanos> period) : period_(period) {}
  bool due(TimePoint now);

 private:
  std::optional<Nanos> period_;
  std::optional<TimePoint> next_;
};

}  // namespace ctn::tool
