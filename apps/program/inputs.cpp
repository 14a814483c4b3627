#include "program/inputs.h"

#include <fmt/format.h>

#include "program/fingerprint.h"
#include "program/text_file.h"

namespace ctn::program {
namespace {

std::string text_of(const Fingerprint& fingerprint) { return fmt::format("{:016x}", fingerprint.value()); }

}  // namespace

std::string fingerprint_of(std::string_view contents) {
  Fingerprint fingerprint;
  fingerprint.add(contents);
  return text_of(fingerprint);
}

std::string short_fingerprint_of(std::string_view contents) { return fingerprint_of(contents).substr(0, 8); }

std::string fingerprint_of_files(const std::vector<std::string>& paths) {
  Fingerprint fingerprint;
  for (const std::string& path : paths) {
    const std::string text = text_of_file(path).value_or("");
    fingerprint.add(fmt::format("{}:", text.size()));  // where one ends and the next begins
    fingerprint.add(text);
  }
  return text_of(fingerprint);
}

std::map<std::string, std::string> fingerprints_of(const std::vector<std::pair<std::string, std::string>>& files) {
  std::map<std::string, std::string> fingerprints;
  for (const auto& [name, path] : files) {
    if (const auto text = text_of_file(path)) fingerprints[name] = fingerprint_of(*text);
  }
  return fingerprints;
}

}  // namespace ctn::program
