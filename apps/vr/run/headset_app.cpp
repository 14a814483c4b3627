#include "run/headset_app.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "run/clock.h"

namespace ctn::vr::run {
namespace {

constexpr double kDatasetHz = 20.0;  // of EuRoC's camera, where a data set does not say it
constexpr double kMaxCameraHz = 60.0;

// What can be promised at 120 Hz (`ms`) on one core, at the phase that is worst, and for so many of the display's
// periods more where they are longer.
std::string bound(double ms, int periods, const Options& options) {
  constexpr double kPeriod = 1e3 / 120.0;
  return fmt::format("{}ms", std::round(ms + periods * (1e3 / options.hz - kPeriod)));
}

std::string inertial_unit_of(const Options& options) {
  if (!options.recorded_samples) return "  IMU: { unscheduled: true, period: 5ms }    # 200 Hz\n";
  const std::chrono::nanoseconds period = *options.recorded_samples;
  return fmt::format("  IMU: {{ unscheduled: true, period: {}ns }}   # {:.4g} Hz\n", period.count(),
                     1.0 / in_seconds(period));
}

std::string nodes_of(const Options& options, bool paced) {
  const std::string rate = fmt::format("{}Hz", options.hz);
  std::string text = "nodes:\n" + inertial_unit_of(options) +
                     "  Int: { unscheduled: true }                 # the integrator follows the IMU\n";
  if (has_camera_clock(options)) {
    text += fmt::format(R"(  {0}: {{ external: true, period: {1}ns }}   # the camera's own clock
  Camera: {{ max_rate: {3}Hz, fallback_rate: {2:.6g}Hz }}
)",
                        kExposure, camera_period(options).count(),
                        std::min(kMaxCameraHz, 1.0 / in_seconds(camera_period(options))), kMaxCameraHz);
  } else {
    text += "  Camera: { max_rate: 60Hz, fallback_rate: 20Hz }   # takes no more pictures in a second\n";
  }
  text += "  VIO: {}                                    # visual-inertial odometry\n";
  if (paced) {
    const auto period = options.display_period();
    text +=
        fmt::format(R"(  {0}: {{ unscheduled: true, period: {2}ns }}   # wakes Timewarp, which follows it
  {1}: {{ unscheduled: true, period: {3}ns }}
  Render: {{ unscheduled: true }}
  Timewarp: {{ unscheduled: true }}
)",
                    kTimewarpPacer, kRenderPacer, (period / kTimewarpLooks).count(), (period / kRenderLooks).count());
  } else {
    text += fmt::format(R"(  Render: {{ max_rate: {0}, fallback_rate: {0} }}
  Timewarp: {{ min_rate: {0}, max_rate: {0}, fallback_rate: {0} }}   # the display's rate
)",
                        rate);
  }
  return text + fmt::format("  display: {{ external: true, period: {}ns }}\n", options.display_period().count());
}

}  // namespace

bool has_camera_clock(const Options& options) { return options.camera_hz || !options.dataset.empty(); }

std::chrono::nanoseconds camera_period(const Options& options) {
  if (options.recorded) return options.recorded->period;
  return std::chrono::nanoseconds(std::llround(1e9 / options.camera_hz.value_or(kDatasetHz)));
}

std::chrono::nanoseconds sample_period(const Options& options) { return options.recorded_samples.value_or(kImuPeriod); }

std::string app_text(const Options& options) {
  const bool paced = options.scheduler == "pacer";
  const bool clocked = has_camera_clock(options);
  // Where pictures come at a rate of their own, one may be that old, and the next one comes a period later.
  const double camera = clocked ? 2.0 * in_ms(camera_period(options)) : 0.0;
  const std::string exposed = clocked ? fmt::format("{}, ", kExposure) : "";
  std::string text =
      R"(# The app of the program `vr`: pose from inertial data and from the camera, drawn, and warped to where the head will be
# when the picture is shown. As vr.yaml, but for what the program does itself: the display has a clock, which it tells.
catan: 1
app: headset
)" + nodes_of(options, paced) +
      R"(edges:
  - IMU -> Int -> Timewarp -> display
  - IMU -> VIO -> Int
  - Camera -> VIO
  - Int -> Render -> Timewarp
)";
  if (clocked) text += fmt::format("  - {} -> Camera\n", kExposure);
  if (paced) text += fmt::format("  - {} -> Timewarp\n  - {} -> Render\n", kTimewarpPacer, kRenderPacer);
  text += fmt::format(
      R"(subchains:
  tracking: [Camera, VIO]
objective:
  - {{ response_time: [IMU, Int, Timewarp, display], weight: 1.0, max: {0} }}           # A: rotation to photon
  - {{ response_time: [IMU, Int, Render, Timewarp, display], weight: 0.5, max: {1} }}   # B: translation to photon
  - {{ response_time: [{4}Camera, VIO, Int, Timewarp, display], weight: 0.005, max: {2} }}   # C: camera to photon
  - {{ response_time: [{4}Camera, VIO, Int, Render, Timewarp, display], weight: 0.005, max: {3} }}
  - {{ response_time: [IMU, VIO, Int, Timewarp, display], weight: 0.005, max: {2} }}
  - {{ response_time: [IMU, VIO, Int, Render, Timewarp, display], weight: 0.005, max: {3} }}
)",
      bound(27.0, 3, options), bound(43.0, 5, options), bound(180.0 + camera, 3, options),
      bound(190.0 + camera, 5, options), exposed);
  return text +
         (paced ? "steal: { off: [tracking] }\n" : "steal: { off: [tracking, Render] }   # only Timewarp steals\n");
}

}  // namespace ctn::vr::run
