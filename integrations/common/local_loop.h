// A loop that is a node: its thread is the framework's, and stays so.
//
//   while (loop.wait()) {
//     if (there is nothing to do) { loop.skip(); continue; }
//     loop.begin();   go round once   loop.end();
//   }
//
// A round gives output if it publishes on a topic that its successors take, or if nothing of the app comes after it.
// One that keeps its own time (a driver) ends its run when it has published on all topics that its successors take:
// what it does then is to wait for what is next.
//
// Until the node is registered, rounds are as without Catan. The first one waits a moment for that. So they are while
// the server has let go of the node's subchain.
//
// Thread safety: all calls by the loop's thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/local_hooks.h"
#include "common/local_node.h"

namespace catan_ros {

class LocalLoop final : public LocalNode, public LoopHook {
 public:
  // Makes the calling thread the node's; null: not at this moment. Called before each round until it has.
  using Attach = std::function<std::unique_ptr<Runs>()>;
  static constexpr std::chrono::milliseconds kRegister{500};  // before it goes round without

  LocalLoop(Binding binding, MessageRuns& message_runs, Attach attach);

  bool wait() override;
  void begin() override;
  void end() override;
  void skip() override;
  void note_published(const std::string& topic) override;

 private:
  void try_attach();

  Attach attach_;
  std::unique_ptr<Runs> runs_;
  bool tried_ = false;
  bool is_triggered_ = false;  // the round is to be a run
  bool output_ = false;
  std::vector<std::string> not_yet_given_;  // of the topics that its successors take, in this round
};

}  // namespace catan_ros
