#include "run/inputs.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>
#include <utility>

#include "program/fingerprint.h"

namespace ctn::navigation::run {
namespace {

std::string fingerprint_of(const std::string& text) {
  program::Fingerprint fingerprint;
  fingerprint.add(text);
  return fmt::format("{:016x}", fingerprint.value());
}

}  // namespace

std::map<std::string, std::string> inputs_of(const Options& options, const DetectorChain* detector) {
  std::map<std::string, std::string> inputs;
  for (const auto& [name, path] : {std::pair{"app", options.app_file}, std::pair{"world", options.world_file},
                                   std::pair{"costs", options.costs}}) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!path.empty() && text << file.rdbuf()) inputs[name] = fingerprint_of(text.str());
  }
  if (detector != nullptr) inputs["detector"] = fingerprint_of(detector->identity());
  return inputs;
}

}  // namespace ctn::navigation::run
