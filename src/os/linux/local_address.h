// The kernel's form of a Unix socket's path; inside os/linux only. Thread safety: pure function.
#pragma once

#include <fmt/format.h>
#include <sys/un.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "base/result.h"

namespace ctn::os {

// kCaller where no socket can have that path.
inline Result<sockaddr_un> local_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  constexpr std::size_t kLongest = sizeof address.sun_path - 1;
  if (path.empty() || path.size() > kLongest || path.find('\0') != std::string::npos) {
    return Error::caller(fmt::format("a socket cannot have the path '{}', of {} bytes", path, path.size()),
                         fmt::format("name a path of 1 to {} bytes, such as /run/catan/app", kLongest));
  }
  std::copy(path.begin(), path.end(), std::begin(address.sun_path));
  return address;
}

}  // namespace ctn::os
