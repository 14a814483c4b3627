// navigation_world: the simulated robot (simulator.h) as a program of ROS, in real time.
//
//   takes   /cmd_vel        how the robot is to move
//           /pose, /path    for the figures of the drive
//   gives   /device/scan    sensor_msgs/LaserScan, 50 Hz
//           /device/odom    nav_msgs/Odometry, 50 Hz, before the scan of its instant
//
// Parameters: ~world, the world's file; ~seed, of noise and drift; ~seconds, how long it lasts at most; ~begin_within,
// how long the nodes may take to come; ~figures, a file for the figures as JSON (empty: none). Time begins when
// somebody takes scans and somebody sends velocities. At the end the figures are printed, and the program ends: with 0,
// or with 1 where the nodes did not come.
#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <ros/transport_hints.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "program/figures.h"
#include "program/snapshot_json.h"
#include "ros1/navigation/simulator.h"
#include "ros1/navigation/standard_messages.h"
#include "ros1/navigation/values.h"
#include "run/outcome.h"
#include "run/shortest_way.h"

namespace ctn::navigation::ros1 {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

class WorldProgram {
 public:
  WorldProgram(world::WorldFile world, const ros::NodeHandle& own)
      : world_(std::move(world)),
        seconds_(own.param("seconds", 60.0)),
        begin_within_(own.param("begin_within", 30.0)),
        figures_file_(own.param<std::string>("figures", "")),
        simulator_(world_, static_cast<std::uint64_t>(own.param("seed", 1)),
                   [this](const run::Reading& reading) { give(reading); }) {
    const ros::TransportHints fast = ros::TransportHints().tcpNoDelay();
    constexpr std::uint32_t kAll = 100;
    velocities_ = handle_.subscribe<TwistMessage>(
        "/cmd_vel", kAll,
        [this](const boost::shared_ptr<const TwistMessage>& message) {
          if (begun_) simulator_.move(now(), velocity_of(*message), stamp_of(*message));
        },
        ros::VoidConstPtr(), fast);
    poses_ = handle_.subscribe<PoseMessage>(
        "/pose", kAll,
        [this](const boost::shared_ptr<const PoseMessage>& message) {
          if (begun_) simulator_.guided(now(), pose_of(*message), stamp_of(*message));
        },
        ros::VoidConstPtr(), fast);
    paths_ = handle_.subscribe<Path>(
        "/path", kAll,
        [this](const boost::shared_ptr<const Path>& message) {
          if (begun_) simulator_.planned(now(), {message.get(), [message](const Path*) {}});
        },
        ros::VoidConstPtr(), fast);
  }

  int run() {
    if (!wait_for_nodes()) return 1;
    begin_ = steady_clock::now();
    begun_ = true;
    ros::CallbackQueue& queue = *ros::getGlobalCallbackQueue();
    while (ros::ok() && !simulator_.over() && now() < seconds_) {
      const nanoseconds left = simulator_.next_due() - now();
      if (left > nanoseconds(0)) {
        queue.callAvailable(ros::WallDuration(std::chrono::duration<double>(left).count()));
      }
      simulator_.advance(now());
    }
    return tell();
  }

 private:
  nanoseconds now() const { return steady_clock::now() - begin_; }

  bool wait_for_nodes() {
    const auto until = steady_clock::now() + begin_within_;
    while (scans_.getNumSubscribers() == 0 || velocities_.getNumPublishers() == 0) {
      if (!ros::ok()) return false;
      if (steady_clock::now() > until) {
        ROS_ERROR("nobody %s: is the launch file's laser_driver, or local_planner, there? (rosnode list)",
                  scans_.getNumSubscribers() == 0 ? "takes /device/scan" : "sends /cmd_vel");
        return false;
      }
      ros::spinOnce();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

  void give(const run::Reading& reading) {
    odometry_.publish(to_message(reading.odometry));
    scans_.publish(to_message(reading.scan));
  }

  int tell() const {
    const std::vector<program::Figure> figures =
        run::drive_figures(simulator_.findings(), world_.explore(), run::shortest_way(world_));
    const double late = std::chrono::duration<double, std::milli>(simulator_.latest()).count();
    std::printf("navigation in '%s' over ROS\n%s  readings at most %.1f ms late\n", world_.name.c_str(),
                program::list_of(figures).c_str(), late);
    std::fflush(stdout);
    if (figures_file_.empty()) return 0;
    const nlohmann::ordered_json document = {
        {"world", world_.name}, {"figures", program::json_of(figures)}, {"late_ms_max", late}};
    std::ofstream file(figures_file_);
    file << document.dump(2) << "\n";
    if (file.flush()) return 0;
    ROS_ERROR("~figures: %s cannot be written", figures_file_.c_str());
    return 1;
  }

  const world::WorldFile world_;
  const std::chrono::duration<double> seconds_;
  const std::chrono::duration<double> begin_within_;
  const std::string figures_file_;
  ros::NodeHandle handle_;
  ros::Publisher odometry_ = handle_.advertise<OdometryMessage>("/device/odom", 10);
  ros::Publisher scans_ = handle_.advertise<LaserScanMessage>("/device/scan", 10);
  ros::Subscriber velocities_, poses_, paths_;
  Simulator simulator_;
  steady_clock::time_point begin_;
  bool begun_ = false;
};

}  // namespace
}  // namespace ctn::navigation::ros1

int main(int count, char** arguments) {
  ros::init(count, arguments, "world");
  const ros::NodeHandle own("~");
  auto world = ctn::navigation::world::read_world(own.param<std::string>("world", ""));
  if (!world) {
    ROS_ERROR("~world: %s", world.error().message().c_str());
    return 2;
  }
  return ctn::navigation::ros1::WorldProgram(std::move(world).value(), own).run();
}
