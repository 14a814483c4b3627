// A plugin in the place of a VIO, for measuring: for each image it computes for CATAN_STAND_IN_MS of CPU time (15 if
// that is not set), and gives the integrator a state that says that nothing moves. It takes IMU data and images as
// OpenVINS's plugin does: images wait until IMU data that is newer comes.
#include <time.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>

#include "illixr/data_format/imu.hpp"
#include "illixr/data_format/opencv_data_types.hpp"
#include "illixr/phonebook.hpp"
#include "illixr/plugin.hpp"
#include "illixr/switchboard.hpp"

using namespace ILLIXR;
using namespace ILLIXR::data_format;

class stand_in_vio : public plugin {
 public:
  stand_in_vio(const std::string& name, phonebook* pb)
      : plugin{name, pb},
        switchboard_{phonebook_->lookup_impl<switchboard>()},
        images_{switchboard_->get_buffered_reader<binocular_cam_type>("cam")},
        state_{switchboard_->get_writer<imu_integrator_input>("imu_integrator_input")} {
    if (const char* const text = std::getenv("CATAN_STAND_IN_MS")) seconds_ = std::strtod(text, nullptr) * 1e-3;
    switchboard_->schedule<imu_type>(
        id_, "imu", [this](const switchboard::ptr<const imu_type>& datum, std::size_t) { take(*datum); });
  }

 private:
  void take(const imu_type& datum) {
    if (!image_ && images_.size() > 0) image_ = images_.dequeue();
    if (!image_ || image_->time >= datum.time) return;
    compute();
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    const imu_params params{0.00016968, 0.002, 1.9393e-05, 0.003, {0.0, 0.0, -9.81}, 1.0, 200.0};
    state_.put(
        state_.allocate(image_->time, duration{0}, params, zero, zero, zero, zero, Eigen::Quaterniond::Identity()));
    image_ = nullptr;
  }

  static double cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
  }
  void compute() const {
    const double until = cpu_seconds() + seconds_;
    while (cpu_seconds() < until) {
    }
  }

  const std::shared_ptr<switchboard> switchboard_;
  switchboard::buffered_reader<binocular_cam_type> images_;
  switchboard::writer<imu_integrator_input> state_;
  switchboard::ptr<const binocular_cam_type> image_;
  double seconds_ = 0.015;
};

PLUGIN_MAIN(stand_in_vio)
