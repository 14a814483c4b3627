#include "run/inputs.h"

#include "program/inputs.h"
#include "world/world_file.h"

namespace ctn::navigation::run {

std::map<std::string, std::string> inputs_of(const Options& options, const DetectorChain* detector) {
  std::map<std::string, std::string> inputs = program::fingerprints_of({{"app", options.app_file},
                                                                        {"world", options.world_file},
                                                                        {"image", world::image_of(options.world_file)},
                                                                        {"costs", options.costs}});
  if (detector != nullptr) inputs["detector"] = program::fingerprint_of(detector->identity());
  return inputs;
}

}  // namespace ctn::navigation::run
