#include "os/machine.h"

#include <utility>

namespace ctn::os {

CpuSet Topology::online() const {
  std::vector<int> numbers;
  for (const Cpu& cpu : cpus) {
    if (cpu.online) numbers.push_back(cpu.number);
  }
  return CpuSet(std::move(numbers));
}

}  // namespace ctn::os
