// The detector that looks at the camera's pictures while the robot drives: the film that the camera plays, and the two
// nodes `preprocess` and `detect` (detector/detector.h). Opened once and used by all runs of a batch: nothing of a run
// is kept in it.
//
// In virtual time nothing is computed: what a run costs follows from the sizes of pictures and network alone, and what
// is found is no figure of any run. So virtual runs are fast, and the same on every machine, which OpenCV's results
// are not to the last digit.
//
// Units: nanoseconds since the run began. Thread safety: prepare() from one thread, detect() from one, the rest any.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "catan/result.h"
#include "detector/detector.h"
#include "detector/film.h"
#include "detector/preprocess.h"
#include "detector/work.h"
#include "run/options.h"

namespace ctn::navigation::run {

class DetectorChain {
 public:
  // Null where the options ask for none. Errors: the film's and the network's.
  static Result<std::shared_ptr<DetectorChain>> open(const Options& options);

  std::size_t frame_at(std::chrono::nanoseconds time) const { return film_.frame_at(time); }
  PictureWork preprocess_work() const { return preprocess_.work(film_.size()); }
  PictureWork detect_work() const { return detector_->work(); }
  // Changes with the film and the detector.
  std::string identity() const;

  // Precondition: a frame of frame_at().
  Result<Prepared> prepare(std::size_t frame) { return preprocess_.run(film_.picture(frame)); }
  std::vector<Detection> detect(const Prepared& picture) { return detector_->run(picture).things; }

 private:
  DetectorChain(Film film, std::unique_ptr<Detector> detector);

  Film film_;
  std::unique_ptr<Detector> detector_;
  Preprocess preprocess_;
};

}  // namespace ctn::navigation::run
