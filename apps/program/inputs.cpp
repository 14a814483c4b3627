#include "program/inputs.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "program/fingerprint.h"

namespace ctn::program {

std::string fingerprint_of(std::string_view contents) {
  Fingerprint fingerprint;
  fingerprint.add(contents);
  return fmt::format("{:016x}", fingerprint.value());
}

std::map<std::string, std::string> fingerprints_of(const std::vector<std::pair<std::string, std::string>>& files) {
  std::map<std::string, std::string> fingerprints;
  for (const auto& [name, path] : files) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!path.empty() && text << file.rdbuf()) fingerprints[name] = fingerprint_of(text.str());
  }
  return fingerprints;
}

}  // namespace ctn::program
