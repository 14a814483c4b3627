// What a run of the detector chain did, counted. Its cost in virtual time is computed from this (cost.h).
//
// All of it follows from the settings and from the size of the pictures, not from what they show.
//
// Thread safety: values.
#pragma once

#include <cstdint>

namespace ctn::navigation {

struct PictureWork {
  std::uint64_t decoded = 0;        // pixels of compressed pictures
  std::uint64_t taps = 0;           // pixels that a filter looked at, for all the pixels that it made
  std::uint64_t moved = 0;          // pixels that were rectified, scaled or normalised
  std::uint64_t gradients = 0;      // pixels, at all sizes of a picture, that were described by their gradient
  std::uint64_t windows = 0;        // places at which a classifier was asked
  std::uint64_t multiply_adds = 0;  // of a network's convolutions
  std::uint64_t emitted = 0;        // numbers that these convolutions emitted, which cost memory rather than arithmetic

  bool operator==(const PictureWork&) const = default;
};

}  // namespace ctn::navigation
