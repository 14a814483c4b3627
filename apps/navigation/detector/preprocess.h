// The node before the detector: makes of a camera's picture what a detector takes.
//
// In order: the JPEG picture is decoded, noise is removed with edges kept (bilateral filter), the lens's distortion is
// removed (rectified), the picture is fitted into the detector's input with its shape kept (letterbox.h), and, for a
// network, made floats from 0 to 1.
//
// Units: pixels. Thread safety: one thread an object. OpenCV's threads: detector.h.
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "catan/result.h"
#include "detector/detector.h"
#include "detector/film.h"

namespace ctn::navigation {

// A lens's radial distortion, as OpenCV's calibration gives it. The film came without a calibration; this is assumed:
// a normal lens that bends lines at the edge a little (the corners of 768 x 576 pixels move by 15 pixels).
struct Lens {
  double focal_length = 1.0;  // over the picture's width
  double k1 = -0.08;
  double k2 = 0.0;
};

struct PreprocessSettings {
  int denoise_diameter = 11;          // of the filter, pixels; 0: none. Sets what the node costs more than all the rest
  std::optional<Lens> lens = Lens{};  // nothing: pictures are as they should be
};

class Preprocess {
 public:
  explicit Preprocess(const InputForm& form, const PreprocessSettings& settings = {});

  // What a run does with a picture of this size, known without one.
  PictureWork work(cv::Size picture) const;

  // Changes with whatever results depend on.
  std::string identity() const;

  // `picture`: JPEG, or another format that OpenCV reads. Errors: it cannot be decoded (kEnvironment).
  Result<Prepared> run(const EncodedPicture& picture);

 private:
  void make_maps(cv::Size picture);

  InputForm form_;
  PreprocessSettings settings_;
  cv::Size of_maps_;  // the size of the pictures that the maps are for
  cv::Mat map_;       // where each rectified pixel is in the camera's picture, fixed point
  cv::Mat map_fine_;
};

}  // namespace ctn::navigation
