// The studies of the headset: the paper's figure 13 with ours, and what it did not measure.
//
// Thread safety: pure functions.
#pragma once

#include "studies.h"

namespace ctn::case_studies {

Study headset(const Setting& setting);       // figure 13: the camera takes a picture when it is triggered
Study headset_20hz(const Setting& setting);  // the same with a camera that has a rate of its own
Study headset_life(const Setting& setting);  // figure 13 in real time beside virtual time

}  // namespace ctn::case_studies
