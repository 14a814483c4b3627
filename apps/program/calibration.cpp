#include "program/calibration.h"

#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "program/batch.h"
#include "program/slowed.h"
#include "program/text_file.h"

namespace ctn::program {
namespace {

using std::chrono::nanoseconds;

constexpr const char* kGive = "give what a run in real time printed with --json, or the --out of a batch of those";

Result<CostRatios> ratios_in(const std::string& file) {
  const auto text = text_of_file(file);
  if (!text) return Error::caller(file + ": cannot be read", kGive);
  const auto document = nlohmann::json::parse(*text, nullptr, false);
  CostRatios ratios;
  if (document.is_object() && document.contains("nodes") && document["nodes"].is_object()) {
    for (const auto& [name, node] : document["nodes"].items()) {
      if (!node.is_object() || !node.contains("cost_ratio") || !node["cost_ratio"].is_number()) continue;
      const double ratio = node["cost_ratio"].get<double>();
      if (ratio > 0.0 && std::isfinite(ratio)) ratios[name] = ratio;
    }
  }
  if (!ratios.empty()) return ratios;
  return Error::caller(file + ": says of no node what its runs cost beside what they are charged (cost_ratio)", kGive);
}

}  // namespace

double ratio_of(const CostRatios& ratios, const std::string& node) {
  const auto found = ratios.find(node);
  return found == ratios.end() ? 1.0 : found->second;
}

std::function<void(Run&)> CostMeter::metered(const std::string& node, std::function<void(Run&)> body) {
  Costs& costs = costs_[node];
  return [this, &costs, body = std::move(body)](Run& run) {
    const auto now = std::chrono::steady_clock::now();
    if (costs.counted_from == std::chrono::steady_clock::time_point{}) costs.counted_from = now + left_out_;
    const nanoseconds begin = thread_cpu_time();
    body(run);
    if (now < costs.counted_from) return;
    costs.used += thread_cpu_time() - begin;
    costs.charged += run.charged();
  };
}

CostRatios CostMeter::ratios() const {
  CostRatios ratios;
  for (const auto& [node, costs] : costs_) {
    if (costs.used <= nanoseconds{0} || costs.charged <= nanoseconds{0}) continue;
    ratios[node] = std::chrono::duration<double>(costs.used) / std::chrono::duration<double>(costs.charged) / slowdown_;
  }
  return ratios;
}

Result<Calibration> Calibration::read(const std::string& path, std::uint64_t first_seed, int runs) {
  Calibration calibration;
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) {
    auto ratios = ratios_in(path);
    if (!ratios) return ratios.error();
    calibration.for_all_ = std::move(ratios).value();
    return calibration;
  }
  for (int run = 0; run < runs; ++run) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(run);
    auto ratios = ratios_in((std::filesystem::path(path) / file_of_run(seed)).string());
    if (!ratios) return ratios.error();
    calibration.by_seed_[seed] = std::move(ratios).value();
  }
  return calibration;
}

const CostRatios& Calibration::of(std::uint64_t seed) const {
  const auto found = by_seed_.find(seed);
  return found == by_seed_.end() ? for_all_ : found->second;
}

}  // namespace ctn::program
