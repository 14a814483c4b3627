// A file descriptor that is closed when its owner goes. It may be a socket, shared memory, or a process (pidfd).
//
// Thread safety: as that of an int.
#pragma once

#include <utility>

namespace ctn::os {

class Descriptor {
 public:
  Descriptor() = default;
  // Takes over a number that the kernel gave; a negative one is none.
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { reset(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      reset();
      number_ = other.release();
    }
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  bool valid() const { return number_ >= 0; }
  // Gives the number away: closing it is the caller's from now on.
  int release() { return std::exchange(number_, -1); }
  void reset();

 private:
  int number_ = -1;
};

}  // namespace ctn::os
