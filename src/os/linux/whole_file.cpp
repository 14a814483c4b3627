#include "os/linux/whole_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "os/linux/errno_text.h"
#include "os/linux/signals_blocked.h"

namespace ctn::os {
namespace {

constexpr mode_t kUsualMode = 0666;  // less what the user's mask takes away
constexpr mode_t kPermissions = 07777;

Error cannot_be_made(const std::string& path, int error) {
  return Error::environment(fmt::format("{} cannot be made: {}", printable(path), errno_text(error)),
                            "name a file in a folder that exists and that you may write to");
}

Error exists_already(const std::string& path) {
  return Error::caller(printable(path) + " exists already", "name a file that does not exist");
}

bool is_same_file(int file, const std::string& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(file, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

// Opened and locked, empty. Whoever has the lock has the name: it gives the file another name, or removes it, before it
// lets go of the lock.
Result<Descriptor> open_unfinished(const std::string& unfinished, const std::string& path) {
  while (true) {
    Descriptor file(::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kUsualMode));
    if (!file.valid()) return cannot_be_made(unfinished, errno);
    if (::flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      return Error::caller(printable(path) + " is being written by another program",
                           "wait until it has ended, or name another file");
    }
    if (!is_same_file(file.number(), unfinished)) continue;  // it was finished, or given up, just now
    if (::ftruncate(file.number(), 0) != 0) return cannot_be_made(unfinished, errno);
    return file;
  }
}

// 0, or the kernel's error.
int rename_to_new(const char* from, const char* to) {
  if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // A file system that cannot do this at once.
  return ::link(from, to) == 0 && ::unlink(from) == 0 ? 0 : errno;
}

}  // namespace

Result<std::unique_ptr<WholeFile>> WholeFile::open_as_it_is(const std::string& path) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.valid()) return cannot_be_made(path, errno);
  return std::unique_ptr<WholeFile>(new WholeFile(path, {}, Existing::kIsReplaced, std::move(file)));
}

Result<std::unique_ptr<WholeFile>> WholeFile::create(const std::string& path, Existing existing) {
  std::string place = path;
  std::optional<mode_t> mode;
  struct stat there {};
  if (::stat(path.c_str(), &there) == 0) {
    if (existing == Existing::kStays) return exists_already(path);
    if (S_ISDIR(there.st_mode)) return cannot_be_made(path, EISDIR);
    if (!S_ISREG(there.st_mode)) return open_as_it_is(path);
    if (::access(path.c_str(), W_OK) != 0) return cannot_be_made(path, errno);
    mode = there.st_mode & kPermissions;
    std::error_code unknown;
    const std::filesystem::path real = std::filesystem::canonical(path, unknown);  // behind links
    if (!unknown) place = real.string();
  }
  std::string unfinished = place + ".unfinished";
  Result<Descriptor> file = open_unfinished(unfinished, path);
  if (!file) return file.error();
  if (mode) static_cast<void>(::fchmod(file->number(), *mode));
  std::unique_ptr<WholeFile> whole(new WholeFile(std::move(place), std::move(unfinished), existing, std::move(*file)));
  return whole;
}

WholeFile::~WholeFile() {
  if (!unfinished_.empty()) ::unlink(unfinished_.c_str());
}

Status WholeFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_.number(), bytes.data(), bytes.size());
    if (count > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && errno != EINTR) {
      return Error::environment(fmt::format("{} cannot be written: {}", printable(path_), errno_text(errno)),
                                "make room on the disk");
    }
  }
  return Done{};
}

Status WholeFile::give_name() {
  if (unfinished_.empty()) return Done{};
  int error = 0;
  if (existing_ == Existing::kStays) {
    error = rename_to_new(unfinished_.c_str(), path_.c_str());
  } else if (std::rename(unfinished_.c_str(), path_.c_str()) != 0) {
    error = errno;
  }
  if (error == EEXIST) return exists_already(path_);
  if (error != 0) return cannot_be_made(path_, error);
  unfinished_.clear();
  return Done{};
}

void WholeFile::take_name_back() {
  if (unfinished_.empty() && existing_ == Existing::kStays) ::unlink(path_.c_str());
}

Status WholeFile::finish(const std::vector<std::unique_ptr<WholeFile>>& files) {
  const SignalsBlocked while_they_are_named;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (Status named = files[i]->give_name(); !named) {
      for (std::size_t before = 0; before < i; ++before) files[before]->take_name_back();
      return named;
    }
  }
  return Done{};
}

Status replace_file(const std::string& path, std::string_view bytes) {
  std::vector<std::unique_ptr<WholeFile>> files;
  Result<std::unique_ptr<WholeFile>> file = WholeFile::create(path, WholeFile::Existing::kIsReplaced);
  if (!file) return file.error();
  files.push_back(std::move(*file));
  if (Status written = files.front()->write(bytes); !written) return written;
  return WholeFile::finish(files);
}

}  // namespace ctn::os
