#include "run/exposures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "drawing/views.h"

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMaxBytes = std::size_t{3} << 30U;  // of pictures in memory

Result<cv::Mat> read_picture(const std::string& path) {
  cv::Mat picture = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (picture.empty()) {
    return Error::environment("the picture " + path + " cannot be read", "is the data set complete?");
  }
  return picture;
}

Result<cv::Mat> draw(drawing::CameraView& view, const Surroundings& surroundings, nanoseconds at) {
  std::vector<std::uint8_t> pixels;
  view.draw(*surroundings.truth(at), pixels);
  return cv::Mat(surroundings.camera().height, surroundings.camera().width, CV_8UC1, pixels.data()).clone();
}

class Drawn final : public Exposures {
 public:
  Drawn(const Surroundings& surroundings, std::unique_ptr<drawing::CameraView> view, std::optional<Clock> clock)
      : surroundings_(surroundings), view_(std::move(view)), clock_(clock) {}

  Result<Exposure> newest(nanoseconds now) override {
    const nanoseconds at = clock_ ? clock_->last(now) : now;
    if (at < nanoseconds(0) || at == newest_.at) return newest_;
    auto picture = draw(*view_, surroundings_, at);
    if (!picture) return picture.error();
    newest_ = {at, std::move(picture).value()};
    return newest_;
  }

 private:
  const Surroundings& surroundings_;
  std::unique_ptr<drawing::CameraView> view_;
  std::optional<Clock> clock_;
  Exposure newest_{nanoseconds(-1), {}};
};

// Which of a data set's pictures is the newest; none: there is none yet.
std::optional<std::size_t> newest_file(const Surroundings& surroundings, nanoseconds now) {
  const auto& files = surroundings.pictures();
  const auto later = std::ranges::upper_bound(files, in_seconds(now), {}, &world::PictureFile::time);
  if (later == files.begin()) return std::nullopt;
  return static_cast<std::size_t>(later - files.begin()) - 1;
}

nanoseconds time_of(const world::PictureFile& file) { return nanoseconds(std::llround(1e9 * file.time)); }

class Recorded final : public Exposures {
 public:
  explicit Recorded(const Surroundings& surroundings) : surroundings_(surroundings) {}

  Result<Exposure> newest(nanoseconds now) override {
    const auto index = newest_file(surroundings_, now);
    if (!index || index == index_) return newest_;
    const world::PictureFile& file = surroundings_.pictures()[*index];
    auto picture = read_picture(file.path);
    if (!picture) return picture.error();
    index_ = index;
    newest_ = {time_of(file), std::move(picture).value()};
    return newest_;
  }

 private:
  const Surroundings& surroundings_;
  std::optional<std::size_t> index_;
  Exposure newest_;
};

class Ready final : public Exposures {
 public:
  explicit Ready(std::vector<Exposure> exposures) : exposures_(std::move(exposures)) {}

  Result<Exposure> newest(nanoseconds now) override {
    const auto later = std::ranges::upper_bound(exposures_, now, {}, &Exposure::at);
    return later == exposures_.begin() ? Exposure{} : *(later - 1);
  }

 private:
  std::vector<Exposure> exposures_;
};

}  // namespace

Result<std::unique_ptr<Exposures>> drawn_exposures(const Surroundings& surroundings,
                                                   const std::optional<Clock>& clock) {
  auto view = drawing::CameraView::open(surroundings.room(), surroundings.camera(), drawing::Screen::kFirst);
  if (!view) return view.error();
  return std::unique_ptr<Exposures>(std::make_unique<Drawn>(surroundings, std::move(view).value(), clock));
}

std::unique_ptr<Exposures> recorded_exposures(const Surroundings& surroundings) {
  return std::make_unique<Recorded>(surroundings);
}

std::vector<nanoseconds> exposure_times(const Surroundings& surroundings, const Clock& clock, nanoseconds end) {
  std::vector<nanoseconds> times;
  const bool recorded = !surroundings.pictures().empty();
  for (const world::PictureFile& file : surroundings.pictures()) {
    if (time_of(file) <= end) times.push_back(time_of(file));
  }
  for (nanoseconds at = clock.next(nanoseconds(0)); !recorded && at <= end; at += clock.period) times.push_back(at);
  return times;
}

std::optional<Clock> clock_of(const std::vector<world::PictureFile>& pictures) {
  std::vector<double> times;
  for (const world::PictureFile& picture : pictures) times.push_back(picture.time);
  return clock_of(times);
}

std::optional<Clock> clock_of(const std::vector<double>& times) {
  if (times.size() < 2) return std::nullopt;
  std::vector<double> distances;
  for (std::size_t i = 1; i < times.size(); ++i) distances.push_back(times[i] - times[i - 1]);
  std::vector<double> sorted = distances;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  // A line through the times, by least squares: over the number of each tick, about the means of both.
  std::vector<double> numbers{0.0};
  for (const double distance : distances) {
    numbers.push_back(numbers.back() + std::max(1.0, std::round(distance / *middle)));
  }
  const auto count = static_cast<double>(times.size());
  double mean_number = 0.0;
  double mean_time = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    mean_number += numbers[i] / count;
    mean_time += times[i] / count;
  }
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    products += (numbers[i] - mean_number) * (times[i] - mean_time);
    squares += (numbers[i] - mean_number) * (numbers[i] - mean_number);
  }
  const double period = products / squares;
  return Clock{nanoseconds(std::llround(1e9 * (mean_time - mean_number * period))),
               nanoseconds(std::llround(1e9 * period))};
}

Result<std::unique_ptr<Exposures>> ready_exposures(const Surroundings& surroundings, const Clock& clock,
                                                   nanoseconds end, const std::function<bool()>& ends) {
  const bool recorded = !surroundings.pictures().empty();
  const std::vector<nanoseconds> times = exposure_times(surroundings, clock, end);
  const CameraModel& camera = surroundings.camera();
  const auto bytes = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * times.size();
  if (bytes > kMaxBytes) {
    return Error::caller(fmt::format("{} pictures of the camera take {} MiB of memory", times.size(), bytes >> 20U),
                         "let it run for a shorter time (--seconds), or give the camera a lower rate (--camera)");
  }
  std::unique_ptr<drawing::CameraView> view;
  if (!recorded) {
    auto opened = drawing::CameraView::open(surroundings.room(), camera, drawing::Screen::kFirst);
    if (!opened) return opened.error();
    view = std::move(opened).value();
  }
  std::vector<Exposure> exposures;
  for (std::size_t index = 0; index < times.size(); ++index) {
    if (ends && ends()) break;
    auto picture =
        recorded ? read_picture(surroundings.pictures()[index].path) : draw(*view, surroundings, times[index]);
    if (!picture) return picture.error();
    exposures.push_back({times[index], std::move(picture).value()});
  }
  return std::unique_ptr<Exposures>(std::make_unique<Ready>(std::move(exposures)));
}

}  // namespace ctn::vr::run
