// The camera's sensor: gives a picture when it is asked for one, or has a clock of its own and gives its newest
// picture.
//
// Times are nanoseconds since the first inertial sample. Thread safety: one thread at a time.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "catan/result.h"
#include "run/clock.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

struct Exposure {
  std::chrono::nanoseconds at{};
  cv::Mat picture;  // grey; empty: there is none yet
};

class Exposures {
 public:
  virtual ~Exposures() = default;
  // The newest picture. Errors: one that cannot be read.
  virtual Result<Exposure> newest(std::chrono::nanoseconds now) = 0;
};

// Draws each picture when it is asked for, without a `clock` as of now: for virtual time, where that takes no time.
// Errors: as CameraView::open(). `surroundings` must outlive it.
Result<std::unique_ptr<Exposures>> drawn_exposures(const Surroundings& surroundings, const std::optional<Clock>& clock);

// Those of a data set, read when they are asked for.
std::unique_ptr<Exposures> recorded_exposures(const Surroundings& surroundings);

// When pictures are taken, until `end`: those of a data set, where there is one, else at the ticks of `clock`.
std::vector<std::chrono::nanoseconds> exposure_times(const Surroundings& surroundings, const Clock& clock,
                                                     std::chrono::nanoseconds end);

// The clock that a data set's pictures keep to, by their time stamps: it passes over pictures that were lost. None:
// there are fewer than two pictures.
std::optional<Clock> clock_of(const std::vector<world::PictureFile>& pictures);
// The same of whatever has these time stamps, in seconds.
std::optional<Clock> clock_of(const std::vector<double>& times);

// Those of exposure_times(), all of them in memory before the run begins. `ends` is asked before each picture: where it
// says so, the rest is left out; empty: none is.
// Errors: as above; more than there is room for (kCaller).
Result<std::unique_ptr<Exposures>> ready_exposures(const Surroundings& surroundings, const Clock& clock,
                                                   std::chrono::nanoseconds end,
                                                   const std::function<bool()>& ends = {});

}  // namespace ctn::vr::run
