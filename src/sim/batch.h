// Many simulations at once, on all CPUs of this machine. What comes out does not depend on how many threads there are.
//
// Thread safety: as each function says.
#pragma once

#include <cstddef>
#include <functional>

namespace ctn::sim {

// Calls work(0) to work(count - 1), each once, from `threads` threads (0: one a CPU); returns when all have returned.
// `work` is called from several threads at once; an exception of the lowest index is thrown on.
void for_each_in_parallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work);

}  // namespace ctn::sim
