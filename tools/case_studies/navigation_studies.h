// The studies of robot navigation: the paper's figures 8 to 12 with our robot, and what goes beyond them.
//
// Thread safety: pure functions.
#pragma once

#include "studies.h"

namespace ctn::case_studies {

Study collisions(const Setting& setting);   // figure 8: map 1
Study exploration(const Setting& setting);  // figure 9: map 2
Study detector(const Setting& setting);     // figures 10 and 11 on one core, 12 on two
Study crowds(const Setting& setting);       // a hundred generated worlds
Study speeds(const Setting& setting);       // map 1 with movers slower and faster
Study life(const Setting& setting);         // map 1 in real time beside virtual time

}  // namespace ctn::case_studies
