// How many clients a server serves, and how long it waits for them.
//
// Thread safety: plain values.
#pragma once

#include <chrono>
#include <cstddef>

#include "base/time.h"

namespace ctn::web {

struct Limits {
  std::size_t clients = 16;
  std::size_t requests = 100;  // on one connection
  Nanos idle = std::chrono::seconds{5};
  Nanos request = std::chrono::seconds{5};  // for its head; its body has as long again
  Nanos answer = std::chrono::seconds{5};   // for each part of it
  Nanos stream = std::chrono::hours{1};
  Nanos step = std::chrono::milliseconds{500};  // between two events; a document is kept for as long
};

// A client that is refused is listened to for as long, and for so many bytes, so that it gets to read why.
constexpr Nanos kLeaveWithin = std::chrono::seconds{1};
constexpr std::size_t kMaxHeard = std::size_t{64} * 1024;

}  // namespace ctn::web
