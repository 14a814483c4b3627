// For tests: a folder of made-up /sys and /proc files, removed at the end of the scope.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "os/linux/files.h"

namespace ctn::os {

class FabricatedTree {
 public:
  FabricatedTree() {
    std::string name = (std::filesystem::temp_directory_path() / "catan-os-XXXXXX").string();
    folder_ = ::mkdtemp(name.data()) ? name : std::string();
  }
  ~FabricatedTree() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  FabricatedTree(const FabricatedTree&) = delete;
  FabricatedTree& operator=(const FabricatedTree&) = delete;

  LinuxRoots roots() const { return {folder_ + "/sys", folder_ + "/proc", folder_ + "/dev"}; }

  // `path` starts with "sys/", "proc/" or "dev/".
  FabricatedTree& write(const std::string& path, const std::string& content) {
    const std::filesystem::path file = std::filesystem::path(folder_) / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
    return *this;
  }

  FabricatedTree& write_cpu(int cpu, const std::string& file, const std::string& content) {
    return write("sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/" + file, content);
  }

 private:
  std::string folder_;
};

}  // namespace ctn::os
