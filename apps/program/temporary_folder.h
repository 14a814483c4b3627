// A folder for files that a program needs while it runs, which goes with this object.
//
// Thread safety: one thread.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "catan/result.h"

namespace ctn::program {

class TemporaryFolder {
 public:
  // Errors (kEnvironment): it cannot be made.
  static Result<std::shared_ptr<TemporaryFolder>> make(const std::string& program);
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  std::string file(const std::string& name) const { return path_ + "/" + name; }
  // Returns the file's path. Errors (kEnvironment): it cannot be written.
  Result<std::string> write(const std::string& name, const std::string& text) const;

 private:
  std::string path_;
};

}  // namespace ctn::program
