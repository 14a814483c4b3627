// What the navigation app's detector chain costs: each step of preprocess, and each detector, on frames of the film
// (CPU time of the thread, medians). Prints them beside the figures that the authors of the paper worked with, and how
// long one of each kind of work took, which is what cost.h says.
//
//   detector_bench [FILE.cfg FILE.weights]...     networks to measure, too
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <opencv2/dnn.hpp>

#include "detector/cost.h"
#include "detector/film.h"
#include "detector/network_detector.h"
#include "detector/people_detector.h"
#include "detector/preprocess.h"
#include "program/slowed.h"

namespace {

using namespace ctn::navigation;

constexpr double kPublishedPreprocess = 25.0;  // ms
constexpr double kAssumedDetect = 150.0;       // ms; the authors do not say
constexpr std::size_t kStep = 20;              // every so many frames of the film

double cpu_time() { return std::chrono::duration<double, std::milli>(ctn::program::thread_cpu_time()).count(); }

struct Measured {
  double median = 0.0;  // ms
  double p95 = 0.0;
};

Measured measure(const Film& film, const std::function<void(const EncodedPicture&)>& run) {
  std::vector<double> times;
  run(film.picture(0));  // sets up what the first run needs
  for (std::size_t frame = 0; frame < film.frames(); frame += kStep) {
    const double begin = cpu_time();
    run(film.picture(frame));
    times.push_back(cpu_time() - begin);
  }
  std::ranges::sort(times);
  return {times[times.size() / 2], times[(times.size() * 95 + 99) / 100 - 1]};
}

Measured measure_preprocess(const Film& film, const InputForm& form, const PreprocessSettings& settings) {
  Preprocess preprocess(form, settings);
  return measure(film, [&](const EncodedPicture& picture) { (void)preprocess.run(picture); });
}

Measured measure_detector(const Film& film, Detector& detector) {
  Preprocess preprocess(detector.form());
  std::vector<Prepared> prepared;
  for (std::size_t frame = 0; frame < film.frames(); frame += kStep) {
    prepared.push_back(preprocess.run(film.picture(frame)).value());
  }
  std::size_t next = 0;
  return measure(film, [&](const EncodedPicture&) { (void)detector.run(prepared[next++ % prepared.size()]); });
}

void print(const std::string& what, const Measured& measured, double modelled) {
  fmt::print("{:<42} {:>9.2f} {:>9.2f} {:>9.2f}\n", what, measured.median, measured.p95, modelled);
}

double factor(double ms, std::uint64_t work) { return work == 0 ? 0.0 : ms * 1e6 / static_cast<double>(work); }

Measured print_detector(const Film& film, const std::string& name, Detector& detector) {
  const InputForm form = detector.form();
  print(fmt::format("preprocess for {}", name), measure_preprocess(film, form, {}),
        1e3 * cost(Preprocess(form).work(film.size()), 1.0));
  const Measured measured = measure_detector(film, detector);
  print(fmt::format("detect: {}, {} x {}", name, form.size.width, form.size.height), measured,
        1e3 * cost(detector.work(), 1.0));
  return measured;
}

// Two sizes of picture tell the two kinds of its work apart.
void print_people(const Film& film) {
  PeopleDetector large;
  PeopleDetector small({512, 384});
  const double first = print_detector(film, "people (HOG)", large).median;
  const double second = print_detector(film, "people (HOG)", small).median;
  const auto count = [](std::uint64_t work) { return static_cast<double>(work); };
  const PictureWork a = large.work();
  const PictureWork b = small.work();
  const double common = count(a.windows) * count(b.gradients) - count(b.windows) * count(a.gradients);
  fmt::print("  gradients: {} and {}, {:.1f} ns each; windows: {} and {}, {:.0f} ns each\n", a.gradients, b.gradients,
             1e6 * (count(a.windows) * second - count(b.windows) * first) / common, a.windows, b.windows,
             1e6 * (first * count(b.gradients) - second * count(a.gradients)) / common);
}

// Nanoseconds of a multiply-add where arithmetic is all: a convolution of 3 x 3 from 256 channels to 256.
double dense_convolution() {
  constexpr int kChannels = 256;
  constexpr int kSide = 40;
  const std::array<int, 4> kernel{kChannels, kChannels, 3, 3};
  const std::array<int, 4> shape{1, kChannels, kSide, kSide};
  cv::dnn::LayerParams parameters;
  parameters.set("kernel_size", 3);
  parameters.set("pad", 1);
  parameters.set("num_output", kChannels);
  parameters.set("bias_term", false);
  parameters.blobs = {cv::Mat(4, kernel.data(), CV_32F, cv::Scalar(0.01))};
  cv::dnn::Net network;
  network.addLayerToPrev("convolution", "Convolution", parameters);
  network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  const cv::Mat input(4, shape.data(), CV_32F, cv::Scalar(0.5));
  std::vector<double> times;
  for (int i = 0; i < 21; ++i) {
    network.setInput(input);
    const double begin = cpu_time();
    (void)network.forward();
    times.push_back(cpu_time() - begin);
  }
  std::ranges::sort(times);
  return factor(times[times.size() / 2], parameters.blobs.front().total() * kSide * kSide);
}

void print_network(const Film& film, const std::string& name, NetworkDetector& network, double multiply_add) {
  const double time = print_detector(film, name, network).median;
  const PictureWork work = network.work();
  fmt::print(
      "  {:.1f} million multiply-adds, {:.2f} million numbers emitted: {:.2f} ns each for the rest of the time\n",
      1e-6 * static_cast<double>(work.multiply_adds), 1e-6 * static_cast<double>(work.emitted),
      factor(time - 1e-6 * multiply_add * static_cast<double>(work.multiply_adds), work.emitted));
}

int fail(const ctn::Error& error) {
  fmt::print(stderr, "{}\n", error.message());
  return error.kind() == ctn::ErrorKind::kCaller ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc % 2 == 0) {
    fmt::print(stderr, "detector_bench: a network is two files: detector_bench [FILE.cfg FILE.weights]...\n");
    return 2;
  }
  const double before = cpu_time();
  const auto film = Film::open();
  if (!film) return fail(film.error());
  fmt::print("film: {} frames of {} x {}, {:.1f} MB, opened in {:.0f} ms of this thread\n\n", film->frames(),
             film->size().width, film->size().height, static_cast<double>(film->bytes()) * 1e-6, cpu_time() - before);
  fmt::print("{:<42} {:>9} {:>9} {:>9}\n", "", "median ms", "p95 ms", "cost.h ms");
  fmt::print("{:<42} {:>9.2f} {:>9}\n", "published: preprocess", kPublishedPreprocess, "");
  fmt::print("{:<42} {:>9.2f} {:>9}\n", "assumed, not published: detect", kAssumedDetect, "");

  const InputForm whole{film->size(), InputForm::Pixels::kBytes};
  const InputForm planes{{416, 416}, InputForm::Pixels::kPlanes};
  const PreprocessSettings bare{0, std::nullopt};
  const PreprocessSettings rectified{0, Lens{}};
  const auto work_of = [&](const InputForm& form, const PreprocessSettings& settings) {
    return Preprocess(form, settings).work(film->size());
  };
  const Measured decode = measure_preprocess(*film, whole, bare);
  const Measured rectify = measure_preprocess(*film, whole, rectified);
  const Measured all = measure_preprocess(*film, whole, {});
  const Measured to_planes = measure_preprocess(*film, planes, {});
  print("preprocess: decoding alone", decode, 1e3 * cost(work_of(whole, bare), 1.0));
  print("  and rectifying", rectify, 1e3 * cost(work_of(whole, rectified), 1.0));
  print("  and the filter", all, 1e3 * cost(work_of(whole, {}), 1.0));
  print("  and letterbox to 416 x 416, floats", to_planes, 1e3 * cost(work_of(planes, {}), 1.0));
  fmt::print("  decoded: {:.2f} ns each; taps: {:.3f} ns each; moved: {:.2f} ns each (rectified), {:.2f} (scaled)\n",
             factor(decode.median, work_of(whole, bare).decoded),
             factor(all.median - rectify.median, work_of(whole, {}).taps),
             factor(rectify.median - decode.median, work_of(whole, rectified).moved),
             factor(to_planes.median - all.median, work_of(planes, {}).moved - work_of(whole, {}).moved));

  print_people(*film);
  const double multiply_add = dense_convolution();
  fmt::print("multiply-adds of a dense convolution: {:.4f} ns each\n", multiply_add);
  for (int i = 1; i + 1 < argc; i += 2) {
    const auto network = NetworkDetector::open({argv[i], argv[i + 1], std::nullopt});
    if (!network) return fail(network.error());
    const std::string path = argv[i];
    print_network(*film, path.substr(path.rfind('/') + 1), **network, multiply_add);
  }
  return 0;
}
