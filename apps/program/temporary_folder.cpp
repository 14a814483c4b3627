#include "program/temporary_folder.h"

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace ctn::program {

Result<std::shared_ptr<TemporaryFolder>> TemporaryFolder::make(const std::string& program) {
  std::error_code error;
  std::string path = (std::filesystem::temp_directory_path(error) / (program + "-XXXXXX")).string();
  if (error || mkdtemp(path.data()) == nullptr) {
    return Error::environment("cannot make a folder for temporary files", "name one in TMPDIR that can be written to");
  }
  return std::make_shared<TemporaryFolder>(std::move(path));
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

Result<std::string> TemporaryFolder::write(const std::string& name, const std::string& text) const {
  std::string path = file(name);
  if (!(std::ofstream(path, std::ios::binary) << text).flush()) {
    return Error::environment("cannot write " + path, "name a folder in TMPDIR that can be written to");
  }
  return path;
}

}  // namespace ctn::program
