// Runs on a slower board than the one at hand.
//
// Thread safety: any thread.
#pragma once

#include <chrono>
#include <functional>

#include "catan/run.h"

namespace ctn::program {

// CPU time that the calling thread has used.
std::chrono::nanoseconds thread_cpu_time();

// The function of a node whose runs take `slowdown` (>= 1) times as much CPU time: each burns the rest when it is done.
std::function<void(Run&)> slowed(std::function<void(Run&)> body, double slowdown);

// The function of a node in life, whose runs end with `effect` (may be none), which virtual time has apart.
std::function<void(Run&)> slowed(std::function<void(Run&)> body, std::function<void(Run&)> effect, double slowdown);

}  // namespace ctn::program
