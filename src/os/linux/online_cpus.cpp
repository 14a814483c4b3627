#include "os/linux/online_cpus.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <string_view>
#include <utility>

#include "os/linux/topology.h"

namespace ctn::os {

Result<CpuSet> OnlineCpus::now() {
  const std::lock_guard lock(mutex_);
  if (!list_.valid()) {
    const std::string path = roots_.sysfs + "/devices/system/cpu/online";
    list_ = Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  }
  std::array<char, 256> buffer{};
  const ssize_t count = ::pread(list_.number(), buffer.data(), buffer.size(), 0);
  const bool whole = count > 0 && static_cast<std::size_t>(count) < buffer.size();
  if (!whole) {
    text_.clear();
    return read_online_cpus(roots_);
  }
  const std::string_view text(buffer.data(), static_cast<std::size_t>(count));
  if (text == text_) return cpus_;
  text_.clear();
  Result<CpuSet> cpus = parse_cpu_list(std::string(text));
  if (!cpus) return read_online_cpus(roots_);
  text_ = text;
  cpus_ = std::move(*cpus);
  return cpus_;
}

}  // namespace ctn::os
