#include "map_file.h"

#include <filesystem>
#include <system_error>

#include "program/command_line.h"

namespace ctn::case_studies {

std::string file_of_map(const std::string& map, const std::string& program) {
  if (map != "1" && map != "2") return map;
  const std::string name = "map" + map + ".yaml";
  const std::filesystem::path beside = std::filesystem::path(program).parent_path() / name;
  std::error_code error;
  return std::filesystem::exists(beside, error) ? beside.string() : program::file_of_the_app(name);
}

}  // namespace ctn::case_studies
