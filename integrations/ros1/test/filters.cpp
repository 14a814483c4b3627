// ROS programs that know nothing of Catan, for the tests: one that makes pairs of messages with a synchronizer of
// message_filters, and those that feed it.
//
//   filters source            publishes on /left, a hundred times a second
//   filters mirror            what it gets of /left goes to /right, with the same stamp, after 5 ms of CPU time
//   filters fuse LOG          pairs of /left and /right of the same stamp are lines of the log, and go to /pairs
//   filters fuse_near LOG     by stamps that are only near each other
#include <geometry_msgs/PointStamped.h>
#include <message_filters/subscriber.h>
#include <message_filters/sync_policies/approximate_time.h>
#include <message_filters/synchronizer.h>
#include <message_filters/time_synchronizer.h>
#include <ros/ros.h>

#include <fstream>
#include <string>

#include <boost/bind/bind.hpp>
#include <boost/function.hpp>

#include "ros1/test/burn.h"

namespace {

using Point = geometry_msgs::PointStamped;

void be_source() {
  ros::NodeHandle handle;
  ros::Publisher left = handle.advertise<Point>("/left", 10);
  Point message;
  const ros::Timer timer = handle.createTimer(ros::Duration(0.01), [&](const ros::TimerEvent&) {
    message.header.stamp = ros::Time::now();
    message.point.x += 1.0;
    left.publish(message);
  });
  ros::spin();
}

void be_mirror() {
  ros::NodeHandle handle;
  ros::Publisher right = handle.advertise<Point>("/right", 10);
  const ros::Subscriber left = handle.subscribe<Point>("/left", 10, [&](const Point::ConstPtr& message) {
    burn(5.0);
    Point mirrored = *message;
    mirrored.point.y = 1.0;
    right.publish(mirrored);
  });
  ros::spin();
}

template <class Synchronizer, class Policy>
void be_fuse(const std::string& log, const Policy& policy) {
  ros::NodeHandle handle;
  ros::Publisher pairs = handle.advertise<Point>("/pairs", 10);
  message_filters::Subscriber<Point> left(handle, "/left", 100);
  message_filters::Subscriber<Point> right(handle, "/right", 100);
  Synchronizer synchronizer(policy);
  synchronizer.connectInput(left, right);
  const boost::function<void(const Point::ConstPtr&, const Point::ConstPtr&)> on_pair = [&](const Point::ConstPtr& a,
                                                                                            const Point::ConstPtr& b) {
    std::ofstream(log, std::ios::app) << a->point.x << " " << b->point.x << "\n";
    pairs.publish(*a);
  };
  synchronizer.registerCallback(boost::bind(on_pair, boost::placeholders::_1, boost::placeholders::_2));
  ros::spin();
}

}  // namespace

int main(int count, char** arguments) {
  const std::string role = count > 1 ? arguments[1] : "";
  const std::string log = count > 2 ? arguments[2] : "";
  ros::init(count, arguments, role);
  if (role == "source") {
    be_source();
  } else if (role == "mirror") {
    be_mirror();
  } else if (role == "fuse") {
    using Exact = message_filters::sync_policies::ExactTime<Point, Point>;
    be_fuse<message_filters::Synchronizer<Exact>>(log, Exact(200));
  } else if (role == "fuse_near") {
    using Near = message_filters::sync_policies::ApproximateTime<Point, Point>;
    be_fuse<message_filters::Synchronizer<Near>>(log, Near(200));
  } else {
    return 2;
  }
  return 0;
}
