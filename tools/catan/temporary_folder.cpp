#include "temporary_folder.h"

#include <cstdlib>
#include <filesystem>
#include <utility>

namespace ctn::tool {

Result<std::unique_ptr<TemporaryFolder>> TemporaryFolder::make(const std::string& name) {
  std::error_code error;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(error);
  std::string path = (parent / (name + "-XXXXXX")).string();
  if (error || mkdtemp(path.data()) == nullptr) {
    return Error::environment("there is no place for temporary files in " + parent.string(),
                              "set TMPDIR to a folder that may be written");
  }
  return std::unique_ptr<TemporaryFolder>(new TemporaryFolder(std::move(path)));
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace ctn::tool
