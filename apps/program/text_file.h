// Files that are read and written in one go.
//
// Thread safety: pure, but for the file.
#pragma once

#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

namespace ctn::program {

// What the file holds; none: it cannot be read.
inline std::optional<std::string> text_of_file(const std::string& path) {
  const std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  // Of a folder; an empty file only fails to add anything.
  if (text.bad()) return std::nullopt;
  return text.str();
}

// The file has these bytes or is as it was, also where several programs write it at the same time. False: it cannot be
// written.
bool replace_file(const std::string& path, std::string_view bytes);

}  // namespace ctn::program
