// Any text as a list of CPUs: what is taken stays within bounds, and printing it and reading it back gives the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "os/os.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ctn::os;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto cpus = parse_cpu_list(text);
  if (!cpus.ok()) {
    require(!cpus.error().message().empty());
    return 0;
  }
  require(cpus->empty() || (cpus->cpus().front() >= 0 && cpus->cpus().back() <= 65535));
  const auto again = parse_cpu_list(to_string(*cpus));
  require(again.ok() && *again == *cpus);
  return 0;
}
