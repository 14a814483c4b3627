#include "studies.h"

#include "navigation_studies.h"

namespace ctn::case_studies {

std::vector<Study> make_studies(const Setting& setting) {
  return {collisions(setting), exploration(setting), detector(setting),
          crowds(setting),     speeds(setting),      life(setting)};
}

}  // namespace ctn::case_studies
