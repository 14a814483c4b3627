#include "program/text_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

namespace ctn::program {

bool replace_file(const std::string& path, std::string_view bytes) {
  const std::string unfinished = fmt::format("{}.{}.unfinished", path, ::getpid());
  std::ofstream file(unfinished, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(unfinished, path, error);
  if (file && !error) return true;
  std::error_code gone;
  std::filesystem::remove(unfinished, gone);
  return false;
}

}  // namespace ctn::program
