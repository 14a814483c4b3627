#include "shared_file_path.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "common/shared_file.h"

namespace ctn::tool {

std::string shared_file_path(const std::string& socket, const std::string& ending) {
  std::string beside = socket + ending;
  if (catan_ros::can_be_shared(beside)) return beside;
  const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
  std::string name = beside.substr(1);
  std::replace(name.begin(), name.end(), '/', '-');
  name = fmt::format("/catan-{}-{}", ::geteuid(), name);
  const bool has_own = runtime != nullptr && runtime[0] == '/' && catan_ros::can_be_shared(runtime + name);
  return (has_own ? runtime : "/dev/shm") + name;
}

}  // namespace ctn::tool
