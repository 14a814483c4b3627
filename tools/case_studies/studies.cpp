#include "studies.h"

#include "headset_studies.h"
#include "navigation_studies.h"

namespace ctn::case_studies {

std::vector<Study> make_studies(const Setting& setting) {
  return {collisions(setting), exploration(setting), detector(setting),     crowds(setting),      speeds(setting),
          life(setting),       headset(setting),     headset_20hz(setting), headset_life(setting)};
}

void leave_out(std::vector<Study>& studies, const std::string& program, const std::string& why) {
  for (Study& study : studies) {
    if (study.program == program && study.missing.empty()) study.missing = why;
  }
}

}  // namespace ctn::case_studies
