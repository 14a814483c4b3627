// What the plan node computes: where the face is and where it goes, from detections that are late and sometimes wrong,
// and how fast the camera should turn.
//
// A particle filter: each particle is a guess (bearing, rate of the bearing). Guesses move with time and now and then
// turn round, as faces do; a picture weights them: near the detection counts, and where a picture shows no face,
// guesses inside the picture lose. The pan rate is the face's mean rate plus a share of the angle that is expected when
// the command takes effect. After too long without a face the camera sweeps, first the way the face was going.
//
// Units: seconds, radians, rad/s. Time is an argument. Thread safety: one thread an object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace ctn::face_tracking {

// What one picture told.
struct Observation {
  double time = 0.0;           // when it was taken
  double pan = 0.0;            // where the camera pointed then; not wrapped
  std::optional<double> face;  // angle from the camera's axis to the face that was found in it
};

class Tracker {
 public:
  static constexpr std::size_t kParticles = 30000;  // sets what the node costs (about 1 ms)

  explicit Tracker(std::uint64_t seed, std::size_t particles = kParticles);

  // Takes in a picture. Its time must not be before that of the one before it.
  void observe(const Observation& observation);

  // The pan rate for a camera that points to `pan` (its encoder) at `time`, not before the last observation.
  double pan_rate(double time, double pan);

  bool searching() const { return searching_; }

 private:
  struct Particles {
    std::vector<double> bearing;
    std::vector<double> rate;
  };

  std::size_t count() const { return weights_.size(); }
  void scatter(double bearing);
  void move(double duration);
  void weigh(const Observation& observation);
  void resample();
  void estimate();
  double normal();

  std::mt19937_64 random_;
  Particles particles_;
  Particles spare_;
  std::vector<double> weights_;

  bool started_ = false;
  double time_ = 0.0;     // of the last observation
  double seen_at_ = 0.0;  // the last time a face was found
  double bearing_ = 0.0;  // mean, at time_
  double rate_ = 0.0;
  bool searching_ = false;
  double sweep_from_ = 0.0;  // pan at which the sweep began
  double sweep_rate_ = 0.0;
};

}  // namespace ctn::face_tracking
