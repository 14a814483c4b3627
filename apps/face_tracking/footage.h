// The pictures that the world is made of, all from Debian packages: a film with faces and photographs of streets from
// opencv-doc, the trained cascade from opencv-data.
//
// The faces are those of a few seconds of film; which frames show one, and where, the cascade itself decides when the
// footage is loaded. The panorama is a ring of photographs, each beside its mirror image, so that it has no seams.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "catan/result.h"

namespace ctn::face_tracking {

struct FootageFiles {
  std::string examples = "/usr/share/doc/opencv-doc/examples/data";
  std::string cascades = "/usr/share/opencv4/haarcascades";

  // A picture of the film's faces, cut out, in a row: where it is there, nobody has to look for them in the film, which
  // takes a second; else it is written. Empty: neither.
  std::string faces{};

  std::string cascade() const { return cascades + "/haarcascade_frontalface_alt2.xml"; }
};

struct Face {
  cv::Mat pixels;  // 8UC3, square
  cv::Mat alpha;   // 32FC3, the same size: 1 on the face, falling to 0 at the border
};

struct Footage {
  std::vector<Face> faces;  // in the film's order; never empty
  cv::Mat panorama;         // 8UC3, 360 degrees at the lens's raw resolution; columns go to the right
};

// Errors (kEnvironment): a file is missing or cannot be decoded, with the package to install; the picture of the faces
// is another one, or cannot be written.
Result<Footage> load_footage(const FootageFiles& files);

}  // namespace ctn::face_tracking
