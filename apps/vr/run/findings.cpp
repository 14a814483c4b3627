#include "run/findings.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "vio/trajectory_error.h"

namespace ctn::vr::run {
namespace {

using program::Figure;
using std::chrono::nanoseconds;

// Mean and percentiles of what was measured many times.
class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  void tell(const std::string& name, std::vector<Figure>& figures) const {
    figures.push_back({name + "_mean", program::mean_of(values_)});
    figures.push_back({name + "_p50", program::percentile_of(values_, 50.0)});
    figures.push_back({name + "_p95", program::percentile_of(values_, 95.0)});
  }

 private:
  std::vector<double> values_;
};

struct PictureErrors {
  Samples degrees;
  Samples pixels;

  void add(const Surroundings& surroundings, const Pose& shown, const Pose& truth) {
    const measures::Depths depths = [&surroundings](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
      return surroundings.room().distance(origin, direction);
    };
    degrees.add(measures::rotation_error(shown, truth));
    if (const auto error = measures::pixel_error(surroundings.eye(), shown, truth, depths)) pixels.add(*error);
  }
  void tell(const std::string& name, std::vector<Figure>& figures) const {
    degrees.tell(name + "_deg", figures);
    pixels.tell(name + "_px", figures);
  }
};

void add_ticks(const Happened& happened, std::vector<Figure>& figures) {
  std::size_t ticks = 0;
  std::size_t missed = 0;
  Samples rotation;
  Samples translation;
  Samples camera;
  for (const Photon& photon : happened.photons) {
    if (photon.tick < counted_from(happened.end)) continue;
    ++ticks;
    if (!photon.fresh) ++missed;
    rotation.add(in_ms(photon.tick - photon.picture.warped_stamp));
    translation.add(in_ms(photon.tick - photon.picture.drawn_stamp));
    if (photon.picture.exposure) camera.add(in_ms(photon.tick - *photon.picture.exposure));
  }
  figures.push_back({"ticks", static_cast<double>(ticks)});
  figures.push_back({"ticks_missed", static_cast<double>(missed)});
  rotation.tell("photon_age_ms rotation", figures);
  translation.tell("photon_age_ms translation", figures);
  camera.tell("photon_age_ms camera", figures);
}

void add_errors(const Happened& happened, const Surroundings& surroundings, bool translational,
                std::vector<Figure>& figures) {
  PictureErrors whole;
  PictureErrors of_age;
  for (const Photon& photon : happened.photons) {
    const std::optional<Pose> truth = surroundings.true_eye(photon.tick);
    const std::optional<Pose> truth_then = surroundings.true_eye(photon.picture.warped_stamp);
    if (photon.tick < counted_from(happened.end) || !truth || !truth_then) continue;
    const Picture& picture = photon.picture;
    const Pose shown = translational ? picture.warped : measures::shown_by_rotation(picture.drawn, picture.warped);
    whole.add(surroundings, shown, *truth);
    const Pose true_from_known = transformed(*truth_then, inverse(picture.known));
    of_age.add(surroundings, transformed(true_from_known, shown), *truth);
  }
  whole.tell("error", figures);
  of_age.tell("age_error", figures);
}

void add_tracking(const Happened& happened, const Surroundings& surroundings, std::vector<Figure>& figures) {
  Samples ages;
  Samples metres;
  Samples degrees;
  std::vector<StampedPose> estimated;
  std::vector<StampedPose> truth;
  std::vector<nanoseconds> times;
  for (const Tracked& tracked : happened.tracked) {
    const double exposed = in_seconds(tracked.exposure);
    const auto true_pose = surroundings.truth(tracked.exposure);
    if (true_pose) {
      estimated.push_back({exposed, tracked.pose});
      truth.push_back({exposed, *true_pose});
    }
    if (tracked.at < counted_from(happened.end)) continue;
    if (true_pose) {
      metres.add(measures::translation_error(tracked.pose, *true_pose));
      degrees.add(measures::rotation_error(tracked.pose, *true_pose));
    }
    ages.add(in_ms(tracked.at - tracked.exposure));
    times.push_back(tracked.at);
  }
  ages.tell("vio_age_ms", figures);
  std::optional<double> rate;
  if (times.size() > 1) rate = static_cast<double>(times.size() - 1) / in_seconds(times.back() - times.front());
  figures.push_back({"vio_hz", rate});
  const TrajectoryError error = absolute_error(estimated, truth);
  figures.push_back({"vio_ate_m", error.poses > 0 ? std::optional(error.position_rmse) : std::nullopt});
  metres.tell("vio_error_m", figures);
  degrees.tell("vio_error_deg", figures);
}

}  // namespace

nanoseconds counted_from(nanoseconds end) { return std::min<nanoseconds>(std::chrono::seconds(4), end / 2); }

std::vector<Figure> figures_of(const Happened& happened, const Surroundings& surroundings, bool translational) {
  std::vector<Figure> figures{{"seconds", in_seconds(happened.end)}};
  add_ticks(happened, figures);
  add_errors(happened, surroundings, translational, figures);
  add_tracking(happened, surroundings, figures);
  return figures;
}

std::vector<nanoseconds> costs_of_tracking(const Happened& happened) {
  std::vector<nanoseconds> costs;
  for (const Tracked& tracked : happened.tracked) {
    if (tracked.at >= counted_from(happened.end)) costs.push_back(tracked.cost);
  }
  return costs;
}

double camera_floor_ms(const Clock& exposures, const std::vector<nanoseconds>& costs, const AfterTracking& after,
                       const Clock& display) {
  constexpr std::size_t kExposures = 3000;
  double sum = 0.0;
  int responses = 0;
  nanoseconds free = exposures.first;  // when tracking is done with the picture before
  std::optional<nanoseconds> shown;    // the tick that shows the newest picture that is shown, and its exposure
  nanoseconds shown_exposure{};
  for (std::size_t picture = 0; picture < kExposures; ++picture) {
    const nanoseconds exposure = exposures.first + static_cast<nanoseconds::rep>(picture) * exposures.period;
    free = std::max(free, exposure) + costs[picture % costs.size()];
    const nanoseconds sample = after.samples.next(free - after.to_int);
    const nanoseconds tick = display.next(sample + after.to_int + after.int_to_tick);
    if (shown && tick != *shown) {
      sum += in_ms(tick - shown_exposure);
      ++responses;
    }
    shown = tick;
    shown_exposure = exposure;
  }
  return responses == 0 ? 0.0 : sum / responses;
}

double floor_ms(const Clock& samples, const Clock& display, nanoseconds cost) {
  constexpr int kTicks = 3000;
  double sum = 0.0;
  int responses = 0;
  nanoseconds tick = display.next(samples.first);
  nanoseconds before = samples.last(tick - cost);
  for (int count = 0; count < kTicks; ++count) {
    tick += display.period;
    const nanoseconds sample = samples.last(tick - cost);
    if (sample == before) continue;  // nothing new reaches the display
    sum += in_ms(tick - before);
    ++responses;
    before = sample;
  }
  return responses == 0 ? 0.0 : sum / responses;
}

}  // namespace ctn::vr::run
