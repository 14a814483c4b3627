// When subchains are let go of: a subchain of which some nodes have registered and others are missing is not triggered.
// Programs that start one after another are complete within a moment. But a program that never comes, or was killed,
// would silence the others for good, also for readers that are no part of the app. So after a second of that the
// subchain is let go of until it is complete: nodes that ask (NodePort::await()) do their work as without Catan.
//
// While all nodes are missing nobody waits, and no time passes. A subchain that was let go of stays so until it is
// complete, whoever of it comes and goes.
//
// Units: Nanos; time is an argument. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::runtime {

class IncompleteSubchains {
 public:
  static constexpr Nanos kPatience = std::chrono::seconds{1};

  explicit IncompleteSubchains(std::size_t subchains) : states_(subchains) {}

  // `waits`: some of its nodes have registered, and others are missing. To be called again and again. True: it is let
  // go of from now on.
  bool look(SubchainId subchain, bool waits, TimePoint now) {
    State& state = states_[subchain.index()];
    if (state.let_go) return false;
    if (!waits) state.since.reset();
    if (waits && !state.since) state.since = now;
    state.let_go = state.since && now - *state.since >= kPatience;
    return state.let_go;
  }

  // All of its nodes are there. True: it had been let go of.
  bool complete(SubchainId subchain) {
    const bool was_let_go = is_let_go(subchain);
    states_[subchain.index()] = {};
    return was_let_go;
  }

  bool is_let_go(SubchainId subchain) const { return states_[subchain.index()].let_go; }

 private:
  struct State {
    std::optional<TimePoint> since;  // some of its nodes wait for others
    bool let_go = false;
  };
  std::vector<State> states_;
};

}  // namespace ctn::runtime
