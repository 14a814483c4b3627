#include "program/inputs.h"

#include <fmt/format.h>

#include "program/fingerprint.h"
#include "program/text_file.h"

namespace ctn::program {

std::string fingerprint_of(std::string_view contents) {
  Fingerprint fingerprint;
  fingerprint.add(contents);
  return fmt::format("{:016x}", fingerprint.value());
}

std::map<std::string, std::string> fingerprints_of(const std::vector<std::pair<std::string, std::string>>& files) {
  std::map<std::string, std::string> fingerprints;
  for (const auto& [name, path] : files) {
    if (const auto text = text_of_file(path)) fingerprints[name] = fingerprint_of(*text);
  }
  return fingerprints;
}

}  // namespace ctn::program
