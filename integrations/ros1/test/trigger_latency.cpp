// When a node's function begins, for a comparison of ports: a line a run, on the monotonic clock in nanoseconds.
//
//   trigger_latency session APP FILE    node `work` of the app, in this process, for two seconds
//   trigger_latency ros FILE            the callback of /data of the ROS node /work, until it is ended
#include <ros/ros.h>
#include <std_msgs/Int64.h>
#include <time.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "catan/session.h"

namespace {

std::int64_t now() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

std::vector<std::int64_t> g_begins;

void on_sample(const std_msgs::Int64::ConstPtr&) { g_begins.push_back(now()); }

void write_begins(const std::string& path) {
  std::ofstream file(path);
  for (const std::int64_t begin : g_begins) file << begin << "\n";
}

int be_session(const std::string& app, const std::string& path) {
  ctn::SessionOptions options;
  options.record = path + ".catan";
  auto session = ctn::Session::open(app, options);
  if (!session) return std::fprintf(stderr, "%s\n", session.error().message().c_str()), 1;
  session->node("work", [](ctn::Run&) { g_begins.push_back(now()); });
  if (const auto started = session->start(); !started) {
    return std::fprintf(stderr, "%s\n", started.error().message().c_str()), 1;
  }
  std::this_thread::sleep_for(std::chrono::seconds{2});
  const auto stopped = session->stop();
  write_begins(path);
  return stopped ? 0 : 1;
}

int be_ros(int count, char** arguments, const std::string& path) {
  ros::init(count, arguments, "work");
  ros::NodeHandle handle;
  const ros::Subscriber data = handle.subscribe("/data", 1, on_sample);
  const ros::WallTimer writer =
      handle.createWallTimer(ros::WallDuration(0.5), [&](const ros::WallTimerEvent&) { write_begins(path); });
  ros::spin();
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  g_begins.reserve(100'000);
  const std::string role = count > 1 ? arguments[1] : "";
  if (role == "session" && count == 4) return be_session(arguments[2], arguments[3]);
  if (role == "ros" && count == 3) return be_ros(count, arguments, arguments[2]);
  return 2;
}
