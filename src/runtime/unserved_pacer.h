// Runs subchains at their own rates while there is no server: the heads that are this program's are triggered every
// period, when the run before has ended. A run that has not ended after ten periods and a second counts as ended: the
// program that was to end it is gone.
//
// Units: Nanos. Thread safety: none; one owner, which is not a node's thread.
#pragma once

#include <vector>

#include "base/time.h"
#include "graph/app.h"
#include "runtime/node_port.h"
#include "runtime/region.h"

namespace ctn::runtime {

class UnservedPacer {
 public:
  struct Head {
    NodePort* port;
    Nanos period;
  };

  // From now on these, and no others. The ports outlive their use.
  void begin(TimePoint now, const std::vector<Head>& heads);
  // Triggers the heads that are due. Returns when to be called again.
  TimePoint pace_heads(TimePoint now);

 private:
  struct Paced {
    Head head;
    TimePoint due;
    TimePoint ended;  // when a run was last known to have ended
  };
  std::vector<Paced> paced_;
};

// The period of a subchain without a server: what the server wrote last, within reason; else the head's
// fallback rate, else ten times a second.
Nanos period_without_server(const graph::Graph& graph, SubchainId subchain, const Region& region);

}  // namespace ctn::runtime
