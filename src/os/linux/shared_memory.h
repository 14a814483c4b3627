// Memory that several processes share, by handing its descriptor over (connection.h).
//
// It is a memfd whose size is sealed: no process, however ill-meaning, can shrink it under another's feet, which would
// end that other process with a bus error. All pages are there from the beginning. What is in it any process that has
// the descriptor can write at any time: trust no value read from it.
//
// Units: bytes. Thread safety: as that of a pointer to the memory. The memory stays where it is when its owner is
// moved.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

class SharedMemory {
 public:
  // New memory, all zero; `name` shows up in /proc/PID/maps. kCaller: size 0 or a name the kernel does not take.
  // kEnvironment: this system gives no such memory, or has less than twice that free.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  // Memory that another process made. kEnvironment: it is no memfd with a sealed size, is smaller than `min_size`, or
  // cannot be mapped.
  static Result<SharedMemory> open(Descriptor descriptor, std::size_t min_size = 1);

  ~SharedMemory();
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  // Whether both are the same memory, mapped twice.
  bool is(const SharedMemory& other) const;

  std::span<std::byte> bytes() const { return bytes_; }
  const Descriptor& descriptor() const { return descriptor_; }

 private:
  SharedMemory(Descriptor descriptor, std::span<std::byte> bytes);
  static Result<SharedMemory> map(Descriptor descriptor, std::size_t size);

  Descriptor descriptor_;
  std::span<std::byte> bytes_;
};

}  // namespace ctn::os
