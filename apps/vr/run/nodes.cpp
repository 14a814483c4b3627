#include "run/nodes.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "program/slowed.h"
#include "run/cost.h"
#include "run/headset_app.h"
#include "vio/cost.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kLittle = std::chrono::microseconds(10);  // what it takes to look at the inputs
constexpr nanoseconds kGlance = std::chrono::microseconds(1);   // and at a clock
constexpr std::size_t kFrames = 8;  // that Render's outputs are in: three in the channel, and those under way
constexpr double kLately = 0.1;     // weight of the newest in what was lately so
// Of a state from which tracking starts: that of a headset that has lain still.
constexpr Uncertainty kAtRest{.tilt = 0.002, .velocity = 0.01, .gyro_bias = 0.002, .accelerometer_bias = 0.02};

nanoseconds charge(Run& run, TrackingNode node, const Work& work, double slowdown) {
  const nanoseconds charged = kLittle + nanoseconds(std::llround(1e9 * slowdown * cost(node, work)));
  run.charge(charged);
  return charged;
}

// So much of the way from what was to what is.
nanoseconds nearer(nanoseconds before, nanoseconds now) {
  return before + nanoseconds(std::llround(kLately * static_cast<double>((now - before).count())));
}

bool is_tracking(const char* node) { return std::string_view(node) == "Camera" || std::string_view(node) == "VIO"; }

}  // namespace

std::optional<nanoseconds> Nodes::Spare::take() {
  const nanoseconds::rep value = value_.exchange(kNothing, std::memory_order_relaxed);
  return value == kNothing ? std::nullopt : std::optional(nanoseconds(value));
}

Nodes::Nodes(Headset& headset, const Surroundings& surroundings, const Options& options,
             std::optional<DrawingParts> drawing)
    : headset_(headset),
      surroundings_(surroundings),
      options_(options),
      drawing_(std::move(drawing)),
      samples_(surroundings.samples()),
      camera_(surroundings.camera()),
      vio_(surroundings.camera()),
      shown_after_((headset.display().period * 3 / 2).count()),
      timewarp_pacer_(headset.display(), options.display_period() / kTimewarpLooks),
      render_pacer_(headset.display(), options.display_period() / kRenderLooks) {
  if (surroundings.start()) {
    vio_.start(*surroundings.start(), kAtRest);
    integrator_.rebase(*surroundings.start());
  }
  if (!drawing_) return;
  for (std::size_t index = 0; index < kFrames; ++index) frames_.push_back(std::make_shared<drawing::Frame>());
}

std::optional<Error> Nodes::failure() const {
  const std::lock_guard lock(failed_mutex_);
  return failed_;
}

void Nodes::fail(const Error& error) {
  const std::lock_guard lock(failed_mutex_);
  if (!failed_) failed_ = error;
}

Pose Nodes::eye_at(const Moving& moving, nanoseconds at) const {
  return transformed(predicted(moving.state, in_seconds(at)), surroundings_.eye().body_from_camera);
}

template <class Host>
void Nodes::add_sensors(Host& host, std::vector<Functions>& functions) {
  auto& to_integrator = host.template channel<std::size_t>("IMU", "Int");
  auto& to_filter = host.template channel<std::size_t>("IMU", "VIO");
  auto& filtered = host.template channel<Filtered>("VIO", "Int");
  auto& to_render = host.template channel<Moving>("Int", "Render");
  auto& to_timewarp = host.template channel<Moving>("Int", "Timewarp");

  const auto read = [this, &to_integrator, &to_filter](Run& run) {
    run.charge(kLittle);
    const std::size_t available = headset_.samples();
    if (available == read_) return run.skip_output();
    for (; read_ < available; ++read_) samples_[read_] = headset_.sample(read_);
    to_integrator.write(run, read_);
    to_filter.write(run, read_);
  };
  const auto integrate = [this, &to_integrator, &filtered, &to_render, &to_timewarp](Run& run) {
    Work work;
    if (const std::size_t* count = to_integrator.read(run)) {
      for (; integrated_ < *count; ++integrated_) work += integrator_.add(samples_[integrated_]);
    }
    const Filtered* base = filtered.read(run);
    if (base != nullptr && base->exposure != based_on_) {
      work += integrator_.rebase(base->state);
      based_on_ = base->exposure;
    }
    charge(run, TrackingNode::kIntegrator, work, 1.0);
    if (integrated_ == 0 || !integrator_.newest()) return run.skip_output();
    const nanoseconds stamp(std::llround(1e9 * samples_[integrated_ - 1].time));
    const Moving moving{*integrator_.newest(), stamp, based_on_};
    to_render.write(run, moving);
    to_timewarp.write(run, moving);
  };
  functions.push_back({"IMU", read, {}});
  functions.push_back({"Int", integrate, {}});
}

template <class Host>
void Nodes::add_tracking(Host& host, std::vector<Functions>& functions) {
  auto& samples = host.template channel<std::size_t>("IMU", "VIO");
  auto& grabbed = host.template channel<std::shared_ptr<const Grabbed>>("Camera", "VIO");
  auto& filtered = host.template channel<Filtered>("VIO", "Int");

  const auto grab = [this, &grabbed](Run& run) {
    const nanoseconds begin = program::thread_cpu_time();
    const auto exposure = headset_.exposure();
    if (!exposure || exposure->picture.empty() || exposure->at == grabbed_) {
      if (!exposure) fail(exposure.error());
      run.charge(kLittle);
      return run.skip_output();
    }
    auto frame = camera_.run(exposure->picture, in_seconds(exposure->at));
    if (!frame) {
      fail(frame.error());
      run.charge(kLittle);
      return run.skip_output();
    }
    grabbed_ = exposure->at;
    const nanoseconds charged = charge(run, TrackingNode::kCamera, frame->work, slowdown_of("Camera"));
    const nanoseconds cost = cost_of_run("Camera", begin, charged);
    grabbed.write(run, std::make_shared<const Grabbed>(Grabbed{exposure->at, std::move(frame).value(), cost}));
  };
  const auto filter = [this, &samples, &grabbed, &filtered](Run& run) {
    const nanoseconds begin = program::thread_cpu_time();
    const std::size_t* count = samples.read(run);
    const std::shared_ptr<const Grabbed>* newest = grabbed.read(run);
    if (count != nullptr) {
      for (; filtered_ < *count; ++filtered_) vio_.add(samples_[filtered_]);
    }
    if (newest == nullptr || (*newest)->exposure == tracked_exposure_) {
      run.charge(kLittle);
      return run.skip_output();
    }
    tracked_exposure_ = (*newest)->exposure;
    const Vio::Result result = vio_.run((*newest)->frame);
    const nanoseconds charged = charge(run, TrackingNode::kVio, result.work, slowdown_of("VIO"));
    if (!result.state) return run.skip_output();
    filtered.write(run, Filtered{*result.state, (*newest)->exposure});
    const nanoseconds cost = (*newest)->cost + cost_of_run("VIO", begin, charged);
    tracked_ = Tracked{{}, (*newest)->exposure, result.state->pose, cost};
  };
  functions.push_back({"Camera", grab, {}});
  functions.push_back({"VIO", filter, [this](Run&) {
                         if (tracked_) headset_.tracked(*std::exchange(tracked_, std::nullopt));
                       }});
}

std::shared_ptr<drawing::Frame> Nodes::free_frame() {
  const auto found = std::ranges::find_if(frames_, [](const auto& frame) { return frame.use_count() == 1; });
  return found == frames_.end() ? std::make_shared<drawing::Frame>() : *found;
}

Nodes::Rendered Nodes::render(Run& run, const Moving& moving) {
  Rendered rendered;
  rendered.begun = headset_.now();
  rendered.number = ++rendered_;
  rendered.pose = eye_at(moving, rendered.begun + nanoseconds(shown_after_.load(std::memory_order_relaxed)));
  rendered.stamp = moving.stamp;
  rendered.exposure = moving.exposure;
  if (drawing_) {
    auto frame = free_frame();
    drawing_->render->draw(rendered.pose, *frame);
    rendered.frame = std::move(frame);
  }
  run.charge(kLittle + drawing_cost(kRenderPixel, surroundings_.eye()));
  return rendered;
}

bool Nodes::warp(Run& run, const Moving& moving, const Rendered& rendered) {
  warp_begun_ = headset_.now();
  const nanoseconds shown_at = headset_.display().next(warp_begun_ + warp_takes_);
  Picture picture;
  picture.drawn = rendered.pose;
  picture.warped = eye_at(moving, shown_at);
  picture.known = transformed(moving.state.state.pose, surroundings_.eye().body_from_camera);
  picture.warped_stamp = moving.stamp;
  picture.drawn_stamp = rendered.stamp;
  picture.exposure = moving.exposure;
  const bool fresh = rendered.number != warped_frame_;
  if (fresh) fresh_frame_begun_ = rendered.begun;
  warped_frame_ = rendered.number;
  if (drawing_) {
    drawing_->timewarp->take(*rendered.frame);
    drawing_->timewarp->warp(picture.warped);
  }
  run.charge(kLittle +
             drawing_cost(options_.translational ? kTranslationalPixel : kRotationalPixel, surroundings_.eye()));
  picture_ = picture;
  return fresh;
}

template <class Host>
void Nodes::add_pictures(Host& host, std::vector<Functions>& functions) {
  auto& to_render = host.template channel<Moving>("Int", "Render");
  auto& to_timewarp = host.template channel<Moving>("Int", "Timewarp");
  auto& frames = host.template channel<Rendered>("Render", "Timewarp");

  const auto draw = [this, &to_render, &frames](Run& run) {
    const Moving* moving = to_render.read(run);
    if (moving == nullptr) {
      run.charge(kLittle);
      return run.skip_output();
    }
    frames.write(run, render(run, *moving));
  };
  const auto turn = [this, &to_timewarp, &frames](Run& run) {
    const Moving* moving = to_timewarp.read(run);
    const Rendered* rendered = frames.read(run);
    if (moving == nullptr || rendered == nullptr) {
      run.charge(kLittle);
      return run.skip_output();
    }
    const bool fresh = warp(run, *moving, *rendered);
    const nanoseconds drawn(render_ended_.load(std::memory_order_relaxed));
    render_spare_.tell(fresh ? warp_begun_ - drawn : nanoseconds(-1));
  };
  const auto finish = [this](Run&) {
    if (!picture_) return;
    const nanoseconds now = headset_.now();
    warp_takes_ = nearer(warp_takes_, now - warp_begun_);
    timewarp_spare_.tell(nanoseconds(paced_tick_.load(std::memory_order_relaxed)) - now);
    if (fresh_frame_begun_) {
      const nanoseconds shown_at = headset_.display().next(now);
      const nanoseconds before(shown_after_.load(std::memory_order_relaxed));
      shown_after_.store(nearer(before, shown_at - *std::exchange(fresh_frame_begun_, std::nullopt)).count(),
                         std::memory_order_relaxed);
    }
    headset_.finished(*std::exchange(picture_, std::nullopt));
  };
  const auto drawn = [this](Run&) { render_ended_.store(headset_.now().count(), std::memory_order_relaxed); };
  functions.push_back({"Render", draw, drawn});
  functions.push_back({"Timewarp", turn, finish});
}

template <class Host>
void Nodes::add_pacers(Host& host, std::vector<Functions>& functions) {
  auto& wake_timewarp = host.template channel<std::size_t>(kTimewarpPacer, "Timewarp");
  auto& wake_render = host.template channel<std::size_t>(kRenderPacer, "Render");
  const auto pace_timewarp = [this, &wake_timewarp](Run& run) {
    run.charge(kGlance);
    if (const auto spare = timewarp_spare_.take()) timewarp_pacer_.done(*spare);
    if (!timewarp_pacer_.due(headset_.now())) return run.skip_output();
    paced_tick_.store(timewarp_pacer_.tick().count(), std::memory_order_relaxed);
    wake_timewarp.write(run, 0);
  };
  const auto pace_render = [this, &wake_render](Run& run) {
    run.charge(kGlance);
    if (const auto spare = render_spare_.take()) render_pacer_.done(*spare);
    if (!render_pacer_.due(headset_.now())) return run.skip_output();
    wake_render.write(run, 0);
  };
  functions.push_back({kTimewarpPacer, pace_timewarp, {}});
  functions.push_back({kRenderPacer, pace_render, {}});
}

template <class Host>
std::vector<Nodes::Functions> Nodes::functions(Host& host) {
  std::vector<Functions> all;
  add_sensors(host, all);
  add_tracking(host, all);
  add_pictures(host, all);
  if (options_.scheduler == "pacer") add_pacers(host, all);
  return all;
}

double Nodes::slowdown_of(const char* node) const { return is_tracking(node) ? options_.tracking_slowdown : 1.0; }

nanoseconds Nodes::cost_of_run(const char* node, nanoseconds begin, nanoseconds charged) const {
  if (!drawing_) {
    const double factor = options_.slowdown * program::ratio_of(options_.calibration.of(options_.seed), node);
    return nanoseconds(std::llround(factor * static_cast<double>(charged.count())));
  }
  const auto used = static_cast<double>((program::thread_cpu_time() - begin).count());
  return nanoseconds(std::llround(options_.slowdown * slowdown_of(node) * used));
}

void Nodes::attach(Session& session, program::CostMeter& meter) {
  for (Functions& functions : this->functions(session)) {
    const double slowdown = options_.slowdown * slowdown_of(functions.node);
    session.node(functions.node, meter.metered(functions.node, program::slowed(std::move(functions.body),
                                                                               std::move(functions.effect), slowdown)));
  }
}

void Nodes::attach(Simulation& simulation) {
  for (Functions& functions : this->functions(simulation)) {
    simulation.node(functions.node, functions.body);
    if (functions.effect) simulation.on_effect(functions.node, functions.effect);
  }
}

}  // namespace ctn::vr::run
