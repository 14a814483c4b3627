#include "common/shared_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace catan_ros {
namespace {

bool is_own_file(const struct stat& found) { return S_ISREG(found.st_mode) && found.st_uid == ::geteuid(); }

}  // namespace

void* map_shared(const std::string& path, std::size_t size) {
  constexpr int kAccess = PROT_READ | PROT_WRITE;
  if (path.empty()) {
    void* const own = ::mmap(nullptr, size, kAccess, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return own != MAP_FAILED ? own : nullptr;
  }
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return nullptr;
  struct stat found {};
  const auto length = static_cast<off_t>(size);
  const bool own = ::fstat(file, &found) == 0 && is_own_file(found);
  const bool sized = own && (found.st_size == length || ::ftruncate(file, length) == 0);
  void* const memory = sized ? ::mmap(nullptr, size, kAccess, MAP_SHARED, file, 0) : MAP_FAILED;
  ::close(file);
  return memory != MAP_FAILED ? memory : nullptr;
}

bool can_be_shared(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) == 0) return is_own_file(found);
  const std::string folder = path.substr(0, path.rfind('/') + 1);
  return ::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) == 0;
}

void unmap_shared(void* memory, std::size_t size) { ::munmap(memory, size); }

}  // namespace catan_ros
