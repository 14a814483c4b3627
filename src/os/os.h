// The operating system as Catan needs it, in four small interfaces: a clock, threads, how they are scheduled, and the
// machine. `Os` is all four, for code that needs several of them; code that needs one takes that one. `os/linux`
// implements them on Linux; `os/fake` in virtual time, and as a wrapper that injects faults. No module above names a
// scheduling class: there are levels, and what was set is read back.
//
// Units, thread safety and cost: as each says; every call may be made from any thread at any time.
#pragma once

#include "os/clock.h"
#include "os/machine.h"
#include "os/thread_scheduling.h"
#include "os/threads.h"

namespace ctn::os {

class Os : public Clock, public Threads, public ThreadScheduling, public Machine {};

}  // namespace ctn::os
