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
#include <utility>

#include "base/result.h"
#include "os/linux/descriptor.h"

namespace ctn::os {

// Memory mapped into this process; unmapped when its owner goes.
class Mapping {
 public:
  Mapping() = default;
  explicit Mapping(std::span<std::byte> bytes) : bytes_(bytes) {}
  ~Mapping();
  Mapping(Mapping&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  Mapping& operator=(Mapping&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

class SharedMemory {
 public:
  // New memory, all zero; `name` shows up in /proc/PID/maps. kCaller: size 0 or a name the kernel does not take.
  // kEnvironment: this system gives no such memory, or has less than twice that free.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  // Memory that another process made. kEnvironment: it is no memfd with a sealed size, is smaller than `min_size`, or
  // cannot be mapped.
  static Result<SharedMemory> open(Descriptor descriptor, std::size_t min_size = 1);

  // Whether both are the same memory, mapped twice.
  bool is(const SharedMemory& other) const;

  std::span<std::byte> bytes() const { return mapping_.bytes(); }
  const Descriptor& descriptor() const { return descriptor_; }
  // Another descriptor of it, by which it cannot be written: for those who are only to read (ReadOnlyMemory).
  // kEnvironment.
  Result<Descriptor> read_only() const;

 private:
  SharedMemory(Descriptor descriptor, Mapping mapping)
      : descriptor_(std::move(descriptor)), mapping_(std::move(mapping)) {}

  Descriptor descriptor_;
  Mapping mapping_;
};

// Memory of that kind which another process made, to be read. It may be written meanwhile.
class ReadOnlyMemory {
 public:
  // As SharedMemory::open(); the descriptor may be one by which it cannot be written.
  static Result<ReadOnlyMemory> open(Descriptor descriptor, std::size_t min_size = 1);

  std::span<const std::byte> bytes() const { return mapping_.bytes(); }
  const Descriptor& descriptor() const { return descriptor_; }

 private:
  ReadOnlyMemory(Descriptor descriptor, Mapping mapping)
      : descriptor_(std::move(descriptor)), mapping_(std::move(mapping)) {}

  Descriptor descriptor_;
  Mapping mapping_;
};

}  // namespace ctn::os
