// When subchains are let go of: a subchain of which some nodes have registered and others are missing is not triggered.
// Programs that start one after another are complete within a moment. But a program that never comes, or was killed,
// would silence the others for good, also for readers that are no part of the app. So after a second of that the
// subchain is let go of until it is complete: nodes that ask (NodePort::await()) do their work as without Catan.
//
// While all nodes are missing nobody waits, and no time passes. A subchain that was let go of stays so until it is
// complete, whoever of it comes and goes.
//
// Nodes are woken at each of both, to look. One that has looked just before, and sleeps just after, misses that; so
// they are woken some times more.
//
// Units: Nanos; time is an argument. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::runtime {

class IncompleteSubchains {
 public:
  static constexpr Nanos kPatience = std::chrono::seconds{1};
  static constexpr int kMoreWakes = 3;

  explicit IncompleteSubchains(std::size_t subchains) : states_(subchains) {}

  // `waits`: some of its nodes have registered, and others are missing. To be called again and again. True: it is let
  // go of from now on.
  bool look(SubchainId subchain, bool waits, TimePoint now) {
    State& state = states_[subchain.index()];
    if (state.let_go) return false;
    if (!waits) state.since.reset();
    if (waits && !state.since) state.since = now;
    state.let_go = state.since && now - *state.since >= kPatience;
    if (state.let_go) state.wakes = kMoreWakes;
    return state.let_go;
  }

  // All of its nodes are there. True: it had been let go of.
  bool complete(SubchainId subchain) {
    State& state = states_[subchain.index()];
    const bool was_let_go = std::exchange(state.let_go, false);
    state.since.reset();
    if (was_let_go) state.wakes = kMoreWakes;
    return was_let_go;
  }

  // Calls wake(SubchainId) for each whose nodes are to be woken once more. To be called now and then.
  template <class Wake>
  void wake_again(Wake&& wake) {
    for (std::size_t index = 0; index < states_.size(); ++index) {
      if (states_[index].wakes == 0) continue;
      --states_[index].wakes;
      wake(SubchainId(index));
    }
  }

  bool is_let_go(SubchainId subchain) const { return states_[subchain.index()].let_go; }

 private:
  struct State {
    std::optional<TimePoint> since;  // some of its nodes wait for others
    bool let_go = false;
    int wakes = 0;  // that are left
  };
  std::vector<State> states_;
};

}  // namespace ctn::runtime
