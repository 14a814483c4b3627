// What a run comes to for who wears the headset, beside what is true.
//
// The error of the picture: what each tick shows (the pose that the picture was drawn at and warped to) beside the true
// pose of the eye at the tick, which is when the photons reach it. In degrees; and in pixels: how far points of the
// room are from where the picture has them, at their true depths (measures/picture_error.h). A tick that shows an old
// picture counts as the others do.
//
// What of that error comes from the picture's age alone (age_error): the same, of a headset that is displaced and
// turned such that it was right about where the eye was at the sample that the picture was warped by. What is left is
// what the wearer did since, as far as it was not predicted: not where tracking has drifted to, which no scheduler can
// help.
//
// The floor of a chain: what its mean response time would be if a run of each node began when its input is there and
// ended just in time for a tick, with nothing else on the cores: the time between two samples that reach the display,
// and from the newer of them to the tick. Of the camera's chain, where tracking takes so much more for one picture than
// for another that a mean says little: with what it took for each picture, one after the other.
//
// Counted is what happens after the first seconds (counted_from()). Units: as named. Thread safety: pure functions.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "measures/picture_error.h"
#include "program/figures.h"
#include "run/clock.h"
#include "run/display.h"
#include "run/headset.h"
#include "run/surroundings.h"

namespace ctn::vr::run {

// After 4 s, in which schedulers measure what runs cost and plan; of a run that is shorter than 8 s, its second half.
std::chrono::nanoseconds counted_from(std::chrono::nanoseconds end);

struct Happened {
  std::vector<Photon> photons;
  std::vector<Tracked> tracked;
  std::chrono::nanoseconds end{};  // of the run
};

// In the order in which they are printed; none where there is nothing to measure, or no truth.
std::vector<program::Figure> figures_of(const Happened& happened, const Surroundings& surroundings, bool translational);

// In ms: mean over the ticks of some seconds. `cost`: from a sample to the picture's end, all of it computing.
double floor_ms(const Clock& samples, const Clock& display, std::chrono::nanoseconds cost);

// The way from a new state of VIO's to the display: Int's next run takes it, which begins when there is a sample.
struct AfterTracking {
  Clock samples;
  std::chrono::nanoseconds to_int{};       // cost from a sample to Int's begin
  std::chrono::nanoseconds int_to_tick{};  // and from there to the picture's end
};
// The same of exposures, over some thousand of them. `costs`: of the pictures in turn, from the exposure to the state;
// from the first again after the last. Precondition: there are some.
double camera_floor_ms(const Clock& exposures, const std::vector<std::chrono::nanoseconds>& costs,
                       const AfterTracking& after, const Clock& display);

// What tracking took for each picture that counts.
std::vector<std::chrono::nanoseconds> costs_of_tracking(const Happened& happened);

}  // namespace ctn::vr::run
