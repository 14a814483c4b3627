#include "nodes.h"

#include <cmath>
#include <utility>

#include "lens.h"
#include "program/slowed.h"

namespace ctn::face_tracking {
namespace {

using program::slowed;

constexpr double kWhollyInView = 0.42;  // radians; beyond it the picture's edge cuts the face
constexpr double kSameFace = 0.06;      // radians between a detection and the truth

}  // namespace

Nodes::Nodes(World& world, const View& view, Clock clock, Detector detector, std::uint64_t seed)
    : world_(world), view_(view), clock_(std::move(clock)), detector_(std::move(detector)), tracker_(seed) {}

template <class Host>
Nodes::Bodies Nodes::bodies(Host& host) {
  auto& frames = host.template channel<Frame>("camera", "detect");
  auto& observations = host.template channel<Observation>("detect", "plan");
  auto& rates = host.template channel<double>("plan", "motor");

  const auto camera = [this, &frames](Run& run) { frames.write(run, take_picture(run.number())); };
  const auto detect = [this, &frames, &observations](Run& run) {
    if (const Frame* frame = frames.read(run)) observations.write(run, find_face(*frame));
  };
  const auto plan = [this, &observations, &rates](Run& run) {
    const Observation* observation = observations.read(run);
    if (observation == nullptr) return;
    tracker_.observe(*observation);
    const double now = clock_();
    rates.write(run, tracker_.pan_rate(now, world_.sight(now).pan));  // the pan as the motor's encoder tells it
  };
  return {camera, detect, plan, rates};
}

void Nodes::attach(Session& session, double slowdown) {
  const Bodies bodies = this->bodies(session);
  const auto motor = [this, &rates = bodies.rates](Run& run) {
    if (const double* rate = rates.read(run)) world_.turn(clock_(), *rate);
  };
  session.node("camera", slowed(bodies.camera, slowdown));
  session.node("detect", slowed(bodies.detect, slowdown));
  session.node("plan", slowed(bodies.plan, slowdown));
  session.node("motor", slowed(motor, slowdown));
}

void Nodes::attach(Simulation& simulation) {
  const Bodies bodies = this->bodies(simulation);
  simulation.node("camera", bodies.camera);
  simulation.node("detect", bodies.detect);
  simulation.node("plan", bodies.plan);
  simulation.node("motor", [this, &rates = bodies.rates](Run& run) {
    const double* rate = rates.read(run);
    command_ = rate != nullptr ? std::optional(*rate) : std::nullopt;
  });
  simulation.on_effect("motor", [this](Run&) {
    if (!command_) return;
    const double now = clock_();
    world_.advance(now);
    world_.turn(now, *command_);
  });
}

Nodes::Frame Nodes::take_picture(std::uint64_t number) {
  Frame frame;
  frame.time = clock_();
  frame.sight = world_.sight(frame.time);
  view_.render(frame.sight, frame.time, number, raw_);
  preprocess_.run(raw_, frame.picture);
  return frame;
}

Observation Nodes::find_face(const Frame& frame) {
  Observation observation{frame.time, frame.sight.pan, std::nullopt};
  if (const auto found = detector_.run(frame.picture)) observation.face = found->angle;
  judge(frame, observation);
  return observation;
}

void Nodes::judge(const Frame& frame, const Observation& observation) {
  const bool in_view = std::abs(frame.sight.angle) < kWhollyInView;
  const bool right = observation.face && std::abs(*observation.face - frame.sight.angle) < kSameFace;
  pictures_.fetch_add(1, std::memory_order_relaxed);
  if (in_view) in_view_.fetch_add(1, std::memory_order_relaxed);
  if (in_view && right) found_.fetch_add(1, std::memory_order_relaxed);
  if (observation.face && !right) wrong_.fetch_add(1, std::memory_order_relaxed);
}

void Nodes::restart_sightings() {
  for (auto* count : {&pictures_, &in_view_, &found_, &wrong_}) count->store(0, std::memory_order_relaxed);
}

Sightings Nodes::sightings() const {
  return {pictures_.load(std::memory_order_relaxed), in_view_.load(std::memory_order_relaxed),
          found_.load(std::memory_order_relaxed), wrong_.load(std::memory_order_relaxed)};
}

}  // namespace ctn::face_tracking
