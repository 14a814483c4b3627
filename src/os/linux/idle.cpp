#include "os/linux/idle.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "os/linux/errno_text.h"

namespace ctn::os {
namespace {

class HeldFile : public ReadyCpus {
 public:
  explicit HeldFile(int file) : file_(file) {}
  ~HeldFile() override { ::close(file_); }
  HeldFile(const HeldFile&) = delete;
  HeldFile& operator=(const HeldFile&) = delete;

 private:
  int file_;
};

}  // namespace

Result<std::unique_ptr<ReadyCpus>> keep_cpus_ready(const LinuxRoots& roots) {
  if (read_line(roots.sysfs + "/devices/system/cpu/cpuidle/current_driver") != "haltpoll") {
    return std::unique_ptr<ReadyCpus>();
  }
  const std::string path = roots.devices + "/cpu_dma_latency";
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  const std::int32_t microseconds = 0;
  if (file >= 0 && ::write(file, &microseconds, sizeof microseconds) == sizeof microseconds) {
    return std::unique_ptr<ReadyCpus>(std::make_unique<HeldFile>(file));
  }
  const std::string why = errno_text(errno);
  if (file >= 0) ::close(file);
  return Error::environment(fmt::format("cannot keep idle virtual CPUs from being given away: {}: {}", path, why),
                            fmt::format("run as a user who may write {}, or pass that device to the container", path));
}

}  // namespace ctn::os
