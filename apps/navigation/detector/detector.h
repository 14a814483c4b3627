// The node that finds things in pictures, and what it takes from the node before it.
//
// There are two: people_detector.h, which needs no files, and network_detector.h, for a network of the user's. What a
// detector takes depends on it, so preprocess.h is told (`InputForm`) and prepares pictures for it.
//
// Threads: a node is one thread, and the scheduler alone places it. OpenCV would start a pool of threads of its own,
// which no plan knows of; opening a detector or a film turns that off, for the whole process, since OpenCV cannot do it
// for one object (cv::setNumThreads(1)). It also makes results the same each time.
//
// Units: pixels of the rectified picture, which is as large as the camera's; x goes to the right, y down. Thread
// safety: one thread an object.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "detector/letterbox.h"
#include "detector/work.h"

namespace ctn::navigation {

struct InputForm {
  enum class Pixels {
    kBytes,   // height x width, each pixel blue, green, red, from 0 to 255
    kPlanes,  // 1 x 3 x height x width floats from 0 to 1; first all that is red, then green, then blue
  };
  cv::Size size;
  Pixels pixels = Pixels::kBytes;
};

// A picture in a detector's form. Passing it on copies no pixels.
struct Prepared {
  cv::Mat input;
  Letterbox letterbox;
  PictureWork work;  // of preparing it
};

struct Detection {
  int label = 0;            // Detector::name() says what it is
  double confidence = 0.0;  // higher is surer; what it means is the detector's
  cv::Rect2d box;           // inside the picture
  bool operator==(const Detection&) const = default;
};

struct Detections {
  std::vector<Detection> things;  // the surest first
  PictureWork work;               // of finding them
};

class Detector {
 public:
  virtual ~Detector() = default;
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;

  virtual InputForm form() const = 0;

  // What each run does, known without one.
  virtual PictureWork work() const = 0;

  // Of what kind a thing with this label is.
  virtual std::string name(int label) const = 0;

  // Changes with whatever results depend on: kind, settings, numbers of a network.
  virtual std::string identity() const = 0;

  // `picture`: prepared for form(). The same picture gives the same detections.
  virtual Detections run(const Prepared& picture) = 0;

 protected:
  Detector() = default;
};

// The order of Detections: the surest first, and one order for those that are equally sure.
void sort_by_confidence(std::vector<Detection>& things);

}  // namespace ctn::navigation
