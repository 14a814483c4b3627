// The port of Relay to Catan: the executor's hook, which lets a Catan server say when components run. A component is
// the node of its name; a component with a timer is an unscheduled node, which its own timer runs.
//
//   ctn::Client client = ...;   client.start();
//   relay_catan::CatanHook hook(client);
//   relay::Executor executor(&hook);
//   executor.add(...);   executor.spin();
//
// Topics are edges: a component subscribes to topics of its node's predecessors, with Keep::kAll where the node's input
// is a queue. Relay delivers what a run published before the run ends, so a subchain that is triggered by that finds
// it.
//
// Thread safety: as relay::Hook says. stop() from any thread.
#pragma once

#include <catan/client.h>

#include <memory>
#include <mutex>
#include <string>

#include "relay.h"

namespace relay_catan {

class CatanHook final : public relay::Hook {
 public:
  // `client` is connected and started, and outlives this.
  explicit CatanHook(ctn::Client& client) : client_(client) {}

  // After the executor was told to stop: ends waits.
  void stop();
  // The first component that could not become a node, and why; empty where all could.
  std::string error() const;

  std::unique_ptr<relay::Pacing> thread_begins(const relay::Component& component) override;
  void thread_helps(const relay::Component& component) override;

 private:
  void complain(const relay::Component& component, const ctn::Error& error);

  ctn::Client& client_;
  std::mutex client_mutex_;  // no node attaches any more once the client stops
  bool stopped_ = false;
  mutable std::mutex error_mutex_;
  std::string error_;
};

}  // namespace relay_catan
