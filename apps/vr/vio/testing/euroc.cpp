#include "vio/testing/euroc.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

namespace ctn::vr::testing {
namespace {

// Rows of comma-separated values after one line of headings; the first value is a time in nanoseconds.
Result<std::vector<std::vector<std::string>>> read_rows(const std::string& name, std::size_t columns) {
  std::ifstream file(name);
  std::string line;
  if (!file || !std::getline(file, line)) {
    return Error::environment("cannot read " + name, "give the folder of a EuRoC sequence, which has mav0 in it");
  }
  std::vector<std::vector<std::string>> rows;
  while (std::getline(file, line)) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty()) continue;
    std::istringstream text(line);
    std::vector<std::string> row;
    for (std::string value; std::getline(text, value, ',');) row.push_back(value);
    if (row.size() < columns) return Error::environment(name + " has a line that is too short: " + line, "");
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return Error::environment(name + " has no rows", "");
  return rows;
}

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

}  // namespace

CameraModel euroc_camera() {
  CameraModel model;
  model.width = 752;
  model.height = 480;
  model.fx = 458.654;
  model.fy = 457.296;
  model.cx = 367.215;
  model.cy = 248.375;
  model.k1 = -0.28340811;
  model.k2 = 0.07395907;
  model.p1 = 0.00019359;
  model.p2 = 1.76187114e-05;
  Eigen::Matrix3d body_from_camera;
  body_from_camera << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,                     //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  model.body_from_camera = {Eigen::Quaterniond(body_from_camera).normalized(),
                            {-0.0216401454975, -0.064676986768, 0.00981073058949}};
  return model;
}

Result<Euroc> read_euroc(const std::string& folder) {
  const std::string root = folder + "/mav0/";
  auto pictures = read_rows(root + "cam0/data.csv", 2);
  if (!pictures) return pictures.error();
  auto samples = read_rows(root + "imu0/data.csv", 7);
  if (!samples) return samples.error();
  auto truth = read_rows(root + "state_groundtruth_estimate0/data.csv", 17);
  if (!truth) return truth.error();
  const long long begin = std::strtoll(pictures->front().front().c_str(), nullptr, 10);
  const auto time_of = [&](const std::string& text) {
    return 1e-9 * static_cast<double>(std::strtoll(text.c_str(), nullptr, 10) - begin);
  };
  const auto vector_at = [](const std::vector<std::string>& row, std::size_t at) {
    return Eigen::Vector3d(number(row[at]), number(row[at + 1]), number(row[at + 2]));
  };
  Euroc euroc;
  for (const auto& row : *pictures) euroc.pictures.push_back({time_of(row[0]), root + "cam0/data/" + row[1]});
  for (const auto& row : *samples) euroc.samples.push_back({time_of(row[0]), vector_at(row, 1), vector_at(row, 4)});
  for (const auto& row : *truth) {
    State state;
    state.time = time_of(row[0]);
    state.pose.position = vector_at(row, 1);
    state.pose.orientation =
        Eigen::Quaterniond(number(row[4]), number(row[5]), number(row[6]), number(row[7])).normalized();
    state.velocity = vector_at(row, 8);
    state.gyro_bias = vector_at(row, 11);
    state.accelerometer_bias = vector_at(row, 14);
    euroc.truth.push_back(state);
  }
  return euroc;
}

}  // namespace ctn::vr::testing
