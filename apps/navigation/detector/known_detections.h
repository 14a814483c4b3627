// What the detector chain finds in each frame of the film, for virtual runs.
//
// There a run costs what its work is worth, whenever its results are known, so that it need not be computed each time.
// Results are those of the very same nodes: a frame's are computed when they are first asked for, and kept. The work is
// known without any computation. With a file, frames that another process computed are not computed again either
// (a frame takes about 0.13 s; Debian's film as a whole 100 s).
//
// Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "catan/result.h"
#include "detector/detector.h"
#include "detector/film.h"
#include "detector/preprocess.h"

namespace ctn::navigation {

class KnownDetections {
 public:
  // `film` outlives this.
  KnownDetections(const Film& film, std::unique_ptr<Detector> detector, const PreprocessSettings& settings = {});

  const Detector& detector() const { return *detector_; }
  PictureWork preprocess_work() const { return preprocess_.work(film_.size()); }
  PictureWork detect_work() const { return detector_->work(); }

  // Precondition: frame < film.frames().
  const std::vector<Detection>& at(std::size_t frame);

  // How many frames are known.
  std::size_t known() const;

  // Takes what a file has; to be called before at(). A file of another film, detector, setting, OpenCV or kind of
  // processor, or one that is damaged, counts as empty, and so does one that is not there.
  void load(const std::string& path);

  // Writes all that is known; whoever reads the file meanwhile sees the old one or the new one, whole. Errors
  // (kEnvironment): it cannot be written.
  Status save(const std::string& path) const;

 private:
  std::string identity() const;

  const Film& film_;
  std::unique_ptr<Detector> detector_;
  Preprocess preprocess_;
  std::vector<std::optional<std::vector<Detection>>> frames_;
};

}  // namespace ctn::navigation
