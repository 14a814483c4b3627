// A network that needs no training: whatever the picture shows, it emits a box of the size of its anchor in the middle
// of each of 2 x 2 cells, of class 1 of two, sure by sigmoid(4) squared. Its input is 64 x 64.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "detector/network_detector.h"
#include "detector/testing/files.h"

namespace ctn::navigation::testing {

inline constexpr int kTinyNumbers = 7 + 7 * 3 * 32 * 32;
inline const double kTinyConfidence = std::pow(1.0 / (1.0 + std::exp(-4.0)), 2.0);

inline std::string tiny_description(const std::string& anchor = "16,32") {
  return "# made for tests\n[net]\nwidth=64\nheight = 64\nchannels=3\n\n"
         "[convolutional]\nfilters=7\nsize=32\nstride=32\npad=0\nactivation=linear\n\n"
         "[yolo]\nmask=0\nanchors=" +
         anchor + "\nclasses=2\nnum=1\n";
}

inline std::string tiny_weights(int numbers = kTinyNumbers) {
  std::vector<float> values(static_cast<std::size_t>(numbers), 0.0F);
  const std::array<float, 7> biases{0.0F, 0.0F, 0.0F, 0.0F, 4.0F, -4.0F, 4.0F};  // x, y, width, height, thing, classes
  for (std::size_t i = 0; i < biases.size() && i < values.size(); ++i) values[i] = biases[i];
  const std::array<std::int32_t, 5> header{0, 2, 0, 0, 0};
  std::string bytes(sizeof(header) + values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), header.data(), sizeof(header));
  if (!values.empty()) std::memcpy(bytes.data() + sizeof(header), values.data(), values.size() * sizeof(float));
  return bytes;
}

inline NetworkFiles tiny_network(const std::string& anchor = "16,32") {
  return {written("tiny.cfg", tiny_description(anchor)), written("tiny.weights", tiny_weights()), std::nullopt};
}

}  // namespace ctn::navigation::testing
