// For tests: a layer under SQLite through which all files go, that fails or watches changes to files on order. While it
// lives it is the default of the process.
//
// Thread safety: none; at most one at a time.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <functional>
#include <new>

namespace ctn::record {

class FaultyVfs {
 public:
  // Called before each write, truncation, synchronisation and removal of a file; what it returns other than SQLITE_OK
  // is the failure. Synchronisation is not carried out: it is slow, and only a machine that stops needs it.
  using Hook = std::function<int()>;

  explicit FaultyVfs(Hook hook) : real_(sqlite3_vfs_find(nullptr)), vfs_(*real_) {
    current() = this;
    hook_ = std::move(hook);
    vfs_.zName = "faulty";
    vfs_.pNext = nullptr;
    vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
    vfs_.xOpen = open;
    vfs_.xDelete = [](sqlite3_vfs*, const char* name, int sync) {
      const int code = current()->hook_();
      return code == SQLITE_OK ? current()->real_->xDelete(current()->real_, name, sync) : code;
    };
    sqlite3_vfs_register(&vfs_, 1);
  }
  ~FaultyVfs() {
    sqlite3_vfs_unregister(&vfs_);
    sqlite3_vfs_register(real_, 1);
    current() = nullptr;
  }
  FaultyVfs(const FaultyVfs&) = delete;
  FaultyVfs& operator=(const FaultyVfs&) = delete;

 private:
  struct File {  // the real file's object follows it in memory
    sqlite3_file base;
  };
  static FaultyVfs*& current() {
    static FaultyVfs* instance = nullptr;
    return instance;
  }
  static sqlite3_file* real(sqlite3_file* file) {
    return reinterpret_cast<sqlite3_file*>(reinterpret_cast<File*>(file) + 1);
  }
  template <class Change>
  static int guarded(Change change) {
    const int code = current() == nullptr ? SQLITE_OK : current()->hook_();
    return code == SQLITE_OK ? change() : code;
  }

  static int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
    file->pMethods = nullptr;
    const int code = current()->real_->xOpen(current()->real_, name, real(file), flags, out_flags);
    if (real(file)->pMethods != nullptr) file->pMethods = &methods();
    return code;
  }

  static const sqlite3_io_methods& methods() {
    static const sqlite3_io_methods kMethods = [] {
      sqlite3_io_methods m{};
      m.iVersion = 1;
      m.xClose = [](sqlite3_file* f) { return real(f)->pMethods->xClose(real(f)); };
      m.xRead = [](sqlite3_file* f, void* to, int size, sqlite3_int64 at) {
        return real(f)->pMethods->xRead(real(f), to, size, at);
      };
      m.xWrite = [](sqlite3_file* f, const void* from, int size, sqlite3_int64 at) {
        return guarded([&] { return real(f)->pMethods->xWrite(real(f), from, size, at); });
      };
      m.xTruncate = [](sqlite3_file* f, sqlite3_int64 size) {
        return guarded([&] { return real(f)->pMethods->xTruncate(real(f), size); });
      };
      m.xSync = [](sqlite3_file*, int) { return guarded([] { return SQLITE_OK; }); };
      m.xFileSize = [](sqlite3_file* f, sqlite3_int64* size) { return real(f)->pMethods->xFileSize(real(f), size); };
      m.xLock = [](sqlite3_file* f, int level) { return real(f)->pMethods->xLock(real(f), level); };
      m.xUnlock = [](sqlite3_file* f, int level) { return real(f)->pMethods->xUnlock(real(f), level); };
      m.xCheckReservedLock = [](sqlite3_file* f, int* held) {
        return real(f)->pMethods->xCheckReservedLock(real(f), held);
      };
      m.xFileControl = [](sqlite3_file* f, int op, void* arg) {
        return real(f)->pMethods->xFileControl(real(f), op, arg);
      };
      m.xSectorSize = [](sqlite3_file* f) { return real(f)->pMethods->xSectorSize(real(f)); };
      m.xDeviceCharacteristics = [](sqlite3_file* f) { return real(f)->pMethods->xDeviceCharacteristics(real(f)); };
      return m;
    }();
    return kMethods;
  }

  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
  Hook hook_;
};

}  // namespace ctn::record
