// Keeps the camera's pictures in a folder, since to draw one takes longer than to take one: what was drawn once is read
// again by later runs.
//
// A picture is a file of its own, FOLDER/KEY/NANOSECONDS.png, where the key tells rooms, trajectories and cameras
// apart; as other programs see it, it is a PNG picture. After the picture's end the file has a fingerprint of what
// comes before, so that one which is damaged, cut off or of another size counts as missing. A file is written under
// another name and renamed, so that it is there as a whole or not at all, whoever writes the same one at the same time.
//
// Units: nanoseconds since the world began. Thread safety: constant; any number of threads and processes may use one
// folder at the same time.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "catan/result.h"
#include "sensors.h"

namespace ctn::vr::drawing {

// Of what the pictures are: fingerprints of the room and the trajectory, and the camera.
std::uint64_t key_of_pictures(std::uint64_t room, std::uint64_t trajectory, const CameraModel& camera);

class PictureCache {
 public:
  // Makes the folder where it is not there. Errors: kCaller, where it is no folder; kEnvironment, where it cannot be
  // made.
  static Result<PictureCache> open(const std::string& folder, std::uint64_t key, const CameraModel& camera);

  // Whether there is a picture of that time; if so, it is in `picture`, one byte a pixel, row by row.
  bool read(std::chrono::nanoseconds time, std::vector<std::uint8_t>& picture) const;
  // Precondition: the picture has the camera's size. Errors: kEnvironment, where it cannot be written.
  Status write(std::chrono::nanoseconds time, const std::vector<std::uint8_t>& picture) const;

  std::string file_of(std::chrono::nanoseconds time) const;

 private:
  PictureCache() = default;

  std::string folder_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace ctn::vr::drawing
