#include "run/detector_chain.h"

#include <fmt/format.h>

#include <utility>

#include "detector/network_detector.h"
#include "detector/people_detector.h"

namespace ctn::navigation::run {
namespace {

Result<std::unique_ptr<Detector>> detector_of(const Options& options) {
  if (options.detector == "hog") return std::unique_ptr<Detector>(std::make_unique<PeopleDetector>());
  NetworkFiles files{options.model.at(0), options.model.at(1), std::nullopt};
  if (options.model.size() > 2) files.names = options.model[2];
  auto network = NetworkDetector::open(files);
  if (!network) return network.error();
  return std::unique_ptr<Detector>(std::move(network).value());
}

}  // namespace

Result<std::shared_ptr<DetectorChain>> DetectorChain::open(const Options& options) {
  if (options.detector == "none") return std::shared_ptr<DetectorChain>();
  auto detector = detector_of(options);
  if (!detector) return detector.error();
  auto film = options.film.empty() ? Film::open() : Film::open(options.film);
  if (!film) return film.error();
  return std::shared_ptr<DetectorChain>(new DetectorChain(std::move(film).value(), std::move(detector).value()));
}

DetectorChain::DetectorChain(Film film, std::unique_ptr<Detector> detector)
    : film_(std::move(film)), detector_(std::move(detector)), preprocess_(detector_->form()) {}

std::string DetectorChain::identity() const {
  return fmt::format("film {:016x}; {}; {}", film_.fingerprint(), preprocess_.identity(), detector_->identity());
}

}  // namespace ctn::navigation::run
