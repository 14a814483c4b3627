// Controllers trigger subchains: they are the state machines of `dispatch`, carried out by an actuator (actuator.h). At
// any time one controller holds a subchain, or none does; it passes from one to the other by a hand-over.
//
//   SubchainPacer  one a subchain (subchain_pacer.h): paces it while it takes turns with no other: it has its CPUs to
//                  itself, or a fixed priority on one
//   CoreDriver     one a core (core_driver.h): takes turns among those that share it
//
// Each is also the watchdog of the subchains that it holds: a run that hangs is suspended, so that it cannot block the
// machine.
//
// Units: in the types. Thread safety: none; each belongs to one thread, as its actuator does.
#pragma once

#include <cstddef>

#include "base/ids.h"
#include "base/time.h"
#include "policy/assignment.h"

namespace ctn::driver {

// Controllers are numbered: those of so many subchains, then those of cores.
inline std::size_t number_of_core(int core, std::size_t subchains) {
  return subchains + static_cast<std::size_t>(core);
}
// The one that is to have a subchain by an assignment.
inline std::size_t holder_of(SubchainId subchain, const policy::SubchainPlace& place, std::size_t subchains) {
  return place.core >= 0 ? number_of_core(place.core, subchains) : subchain.index();
}

class Controller {
 public:
  virtual ~Controller() = default;

  // Does what is due: follows the newest assignment, and decides what its subchains are to do. When to step again, at
  // the latest: sooner if there is a new assignment, if something is handed over to it, or if a completion comes that
  // it asked for. `now` never goes backwards; a step may come early, late, or twice.
  virtual TimePoint step(TimePoint now) = 0;

 protected:
  Controller() = default;
  Controller(const Controller&) = default;
  Controller& operator=(const Controller&) = default;
};

}  // namespace ctn::driver
