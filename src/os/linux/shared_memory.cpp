#include "os/linux/shared_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "os/linux/errno_text.h"
#include "os/linux/files.h"

namespace ctn::os {
namespace {

constexpr int kSizeSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
constexpr std::size_t kMaxName = 249;            // what the kernel takes
constexpr unsigned kNoExecutableSeal = 0x0008U;  // MFD_NOEXEC_SEAL, since Linux 6.3; not every <sys/mman.h> names it

Error cannot_create(std::size_t size, const std::string& why, std::string hint) {
  return Error::environment(fmt::format("cannot make {} bytes of shared memory: {}", size, why), std::move(hint));
}

Error cannot_open(const std::string& why) {
  return Error::environment(
      "cannot use the shared memory that was handed over: " + why,
      "the program that handed it over is another version of Catan: use the same version on both sides");
}

// Some systems allow only memory that cannot be executed (vm.memfd_noexec), others do not know the difference.
Descriptor make_memory_file(const std::string& name) {
  const unsigned flags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  const long made = ::syscall(SYS_memfd_create, name.c_str(), flags | kNoExecutableSeal);
  if (made >= 0 || errno != EINVAL) return Descriptor(static_cast<int>(made));
  return Descriptor(static_cast<int>(::syscall(SYS_memfd_create, name.c_str(), flags)));
}

std::uint64_t free_memory() {
  constexpr std::uint64_t kKibibyte = 1024;
  const std::optional<std::string> facts = read_text("/proc/meminfo");
  const std::string available = facts ? find_value(*facts, "MemAvailable").value_or("") : "";
  const std::optional<std::int64_t> kibibytes = parse_integer(available.substr(0, available.find(' ')));
  if (kibibytes && *kibibytes >= 0) return static_cast<std::uint64_t>(*kibibytes) * kKibibyte;
  struct sysinfo system {};
  return ::sysinfo(&system) == 0 ? std::uint64_t{system.freeram} * system.mem_unit : 0;
}

// The kernel reports no error when more memory is asked for than there is: it kills processes, of any user, until there
// is enough. So no more than this is asked for.
bool may_have(std::size_t size) { return size <= free_memory() / 2; }

Result<Mapping> map(const Descriptor& file, std::size_t size, int protection) {
  void* const memory = ::mmap(nullptr, size, protection, MAP_SHARED | MAP_POPULATE, file.number(), 0);
  if (memory == MAP_FAILED) {
    return Error::environment(fmt::format("cannot map {} bytes of shared memory: {}", size, errno_text(errno)),
                              "raise the limit of address space (`ulimit -v`), or free memory");
  }
  return Mapping({static_cast<std::byte*>(memory), size});
}

// Of memory that another process made.
Result<std::size_t> sealed_size(const Descriptor& file, std::size_t min_size) {
  if (!file.valid()) return cannot_open("there is no descriptor");
  const int seals = ::fcntl(file.number(), F_GET_SEALS);
  if (seals < 0) return cannot_open("it is not memory but another kind of file");
  if ((seals & kSizeSeals) != kSizeSeals) return cannot_open("its size is not sealed, so it could vanish in use");
  struct stat facts {};
  if (::fstat(file.number(), &facts) != 0) return cannot_open(errno_text(errno));
  const auto size = static_cast<std::size_t>(facts.st_size);
  if (size != 0 && size >= min_size) return size;
  return cannot_open(fmt::format("it has {} bytes and needs {}", size, min_size));
}

}  // namespace

Mapping::~Mapping() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

Result<SharedMemory> SharedMemory::create(const std::string& name, std::size_t size) {
  if (size == 0 || size > static_cast<std::size_t>(std::numeric_limits<off_t>::max())) {
    return Error::caller(fmt::format("shared memory cannot have {} bytes", size), "ask for at least 1 byte, and less");
  }
  if (name.size() > kMaxName || name.find('\0') != std::string::npos) {
    return Error::caller("shared memory cannot be called that", fmt::format("use at most {} characters", kMaxName));
  }
  if (!may_have(size)) {
    return cannot_create(size, "that is more than half of the memory that is free", "ask for less, or free memory");
  }
  Descriptor file = make_memory_file(name);
  if (!file.valid()) {
    return cannot_create(size, errno_text(errno),
                         "allow the system call memfd_create (a container's filter may forbid it, or the kernel was "
                         "built without CONFIG_MEMFD_CREATE)");
  }
  // Allocated now, because memory that is missing later ends the process that touches it.
  if (::ftruncate(file.number(), static_cast<off_t>(size)) != 0 ||
      ::fallocate(file.number(), 0, 0, static_cast<off_t>(size)) != 0) {
    return cannot_create(size, errno_text(errno), "free memory, or raise the memory limit of this control group");
  }
  if (::fcntl(file.number(), F_ADD_SEALS, kSizeSeals) != 0) {
    return cannot_create(size, "its size cannot be sealed: " + errno_text(errno),
                         "use a kernel with sealing (since 3.17)");
  }
  Result<Mapping> mapping = map(file, size, PROT_READ | PROT_WRITE);
  if (!mapping) return mapping.error();
  return SharedMemory(std::move(file), std::move(*mapping));
}

Result<SharedMemory> SharedMemory::open(Descriptor descriptor, std::size_t min_size) {
  const Result<std::size_t> size = sealed_size(descriptor, min_size);
  if (!size) return size.error();
  Result<Mapping> mapping = map(descriptor, *size, PROT_READ | PROT_WRITE);
  if (!mapping) return mapping.error();
  return SharedMemory(std::move(descriptor), std::move(*mapping));
}

Result<Descriptor> SharedMemory::read_only() const {
  const std::string path = fmt::format("/proc/self/fd/{}", descriptor_.number());
  Descriptor reader(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (reader.valid()) return reader;
  return Error::environment("cannot open shared memory for reading: " + errno_text(errno),
                            "mount /proc, and allow more open files (`ulimit -n`)");
}

Result<ReadOnlyMemory> ReadOnlyMemory::open(Descriptor descriptor, std::size_t min_size) {
  const Result<std::size_t> size = sealed_size(descriptor, min_size);
  if (!size) return size.error();
  Result<Mapping> mapping = map(descriptor, *size, PROT_READ);
  if (!mapping) return mapping.error();
  return ReadOnlyMemory(std::move(descriptor), std::move(*mapping));
}

bool SharedMemory::is(const SharedMemory& other) const {
  struct stat one {};
  struct stat two {};
  return ::fstat(descriptor_.number(), &one) == 0 && ::fstat(other.descriptor_.number(), &two) == 0 &&
         one.st_dev == two.st_dev && one.st_ino == two.st_ino;
}

}  // namespace ctn::os
