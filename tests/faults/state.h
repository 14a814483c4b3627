// What the programs of the pipeline that is tormented (pipeline.h) and their tormentor tell each other: a file that all
// have mapped. Times are of the monotonic clock, in nanoseconds.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>

namespace ctn::faults {

// Each node is a program of its own; eye and hand are one subchain, each of the others is one.
constexpr std::array<const char*, 5> kNodes{"eye", "hand", "map", "log", "voice"};
enum Node : std::size_t { kEye, kHand, kMap, kLog, kVoice };

struct alignas(64) NodeState {
  std::atomic<std::uint64_t> runs{0};       // that have ended
  std::atomic<std::uint64_t> number{0};     // of the newest
  std::atomic<std::uint64_t> went_back{0};  // how often a run's number was not above that of the run before
  std::atomic<std::int64_t> began{0};       // the newest run
  std::atomic<std::int64_t> ended{0};
  std::atomic<std::int64_t> completed{0};  // when the newest run that has ended began
  std::atomic<std::uint32_t> served{0};    // as the client says
  std::atomic<std::int64_t> overrun{0};    // to be burnt in the next run beside what it costs
  std::atomic<std::int64_t> overran{0};    // when a run that was given more to burn has ended
  std::atomic<std::uint32_t> hang{0};      // runs do not end while it is set
  std::atomic<std::uint32_t> hanging{0};   // one that does not
  std::atomic<std::int32_t> child{0};      // that the program forked when it was told to (SIGUSR1)
};

struct State {
  std::array<NodeState, kNodes.size()> nodes;
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

// The file's bytes are all zero when it is made, which is how a State begins.
class MappedState {
 public:
  MappedState(const std::string& path, bool make) {
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | (make ? O_CREAT : 0), 0600);
    if (file < 0 || (make && ::ftruncate(file, sizeof(State)) != 0)) throw std::runtime_error("cannot open " + path);
    void* const memory = ::mmap(nullptr, sizeof(State), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (memory == MAP_FAILED) throw std::runtime_error("cannot map " + path);
    state_ = static_cast<State*>(memory);
  }
  ~MappedState() { ::munmap(state_, sizeof(State)); }
  MappedState(const MappedState&) = delete;
  MappedState& operator=(const MappedState&) = delete;

  NodeState& node(std::size_t index) const { return state_->nodes.at(index); }

 private:
  State* state_ = nullptr;
};

}  // namespace ctn::faults
