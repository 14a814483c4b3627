// Data sets in EuRoC's format are downloaded from others: reading one must never crash, and whatever is accepted must
// be finite and in order of time.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "world/euroc.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

template <class Rows>
void check(const Rows& rows) {
  if (!rows) {
    require(!rows.error().message().empty());
    return;
  }
  require(!rows->empty());
  require(std::adjacent_find(rows->begin(), rows->end(), [](const auto& one, const auto& next) {
            return one.nanoseconds >= next.nanoseconds;
          }) == rows->end());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto imu = ctn::vr::world::parse_euroc_imu(text, "fuzz");
  check(imu);
  if (imu) {
    for (const auto& row : *imu) require(row.sample.angular_rate.allFinite() && row.sample.acceleration.allFinite());
  }
  check(ctn::vr::world::parse_euroc_pictures(text, "fuzz"));
  const auto truth = ctn::vr::world::parse_euroc_truth(text, "fuzz");
  check(truth);
  if (truth) {
    for (const auto& row : *truth) require(row.state.pose.orientation.coeffs().allFinite());
  }
  const auto camera = ctn::vr::world::parse_euroc_camera(text, "fuzz");
  if (camera)
    require(camera->width > 0 && camera->fx > 0.0 && camera->body_from_camera.orientation.coeffs().allFinite());
  return 0;
}
