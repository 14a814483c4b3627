// A folder for what is not to be kept; removed with all that is in it.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "base/result.h"

namespace ctn::tool {

class TemporaryFolder {
 public:
  // `name`: what its own begins with. kEnvironment: there is no place for it.
  static Result<std::unique_ptr<TemporaryFolder>> make(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace ctn::tool
