#include "ros1/navigation/robot_nodes.h"

#include <ros/console.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <ros/transport_hints.h>
#include <ros/wall_timer.h>

#include <functional>
#include <optional>
#include <utility>

#include "nodes/global_localizer.h"
#include "nodes/global_mapper.h"
#include "nodes/global_planner.h"
#include "nodes/local_mapper.h"
#include "nodes/local_planner.h"
#include "nodes/navigation_command.h"
#include "nodes/scan_filter.h"
#include "ros1/navigation/odometry_history.h"
#include "ros1/navigation/standard_messages.h"
#include "ros1/navigation/values.h"
#include "world/world_file.h"

namespace ctn::navigation::ros1 {
namespace {

constexpr std::uint32_t kNewest = 1;    // of which only the last one counts
constexpr std::uint32_t kEachOne = 50;  // of which each counts: a second of scans

// A message that is shared with roscpp.
template <class T>
std::shared_ptr<const T> shared_of(const boost::shared_ptr<const T>& message) {
  return {message.get(), [message](const T*) {}};
}

// What nodes have in common: topics, and when they work.
class Working : public RobotNode {
 protected:
  template <class T>
  ros::Publisher gives(const std::string& topic, std::uint32_t queue = kNewest) {
    return handle_.advertise<T>(topic, queue);
  }
  // Who subscribes later gets the last one: for what is given seldom, and maybe never again.
  template <class T>
  ros::Publisher gives_and_keeps(const std::string& topic) {
    return handle_.advertise<T>(topic, kNewest, true);
  }

  template <class T>
  void takes(const std::string& topic, std::uint32_t queue,
             std::function<void(const boost::shared_ptr<const T>&)> callback) {
    subscribers_.push_back(handle_.subscribe<T>(topic, queue, std::move(callback), ros::VoidConstPtr(),
                                                ros::TransportHints().tcpNoDelay()));
  }

  // The last message; null as long as none has come.
  template <class T>
  void keeps(const std::string& topic, std::shared_ptr<const T>& newest) {
    takes<T>(topic, kNewest, [&newest](const boost::shared_ptr<const T>& message) { newest = shared_of(message); });
  }

  // Works with each message or, with ~rate, with what has come last at that rate.
  template <class T>
  void works_on(const std::string& topic, std::function<void(const std::shared_ptr<const T>&)> work) {
    const double rate = ros::NodeHandle("~").param("rate", 0.0);
    if (rate <= 0.0) {
      takes<T>(topic, kNewest, [work](const boost::shared_ptr<const T>& message) { work(shared_of(message)); });
      return;
    }
    const auto newest = std::make_shared<std::shared_ptr<const T>>();
    takes<T>(topic, kNewest, [newest](const boost::shared_ptr<const T>& message) { *newest = shared_of(message); });
    timer_ = handle_.createWallTimer(ros::WallDuration(1.0 / rate), [newest, work](const ros::WallTimerEvent&) {
      if (*newest) work(*newest);
    });
  }

 private:
  ros::NodeHandle handle_;
  std::vector<ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
};

class LaserDriver final : public Working {
 public:
  LaserDriver() {
    takes<OdometryMessage>("/device/odom", kEachOne, [this](const boost::shared_ptr<const OdometryMessage>& message) {
      history_.add(odometry_of(*message));
    });
    takes<LaserScanMessage>("/device/scan", kNewest, [this](const boost::shared_ptr<const LaserScanMessage>& message) {
      Scan scan = scan_of(*message);
      const std::optional<Odometry> odometry = history_.at(scan.stamp);
      if (odometry) readings_.publish(run::Reading{std::move(scan), *odometry});
    });
  }

 private:
  OdometryHistory history_;
  ros::Publisher readings_ = gives<run::Reading>("/laser");
};

class OdometryDriver final : public Working {
 public:
  OdometryDriver() {
    takes<OdometryMessage>("/device/odom", kNewest, [this](const boost::shared_ptr<const OdometryMessage>& message) {
      odometry_.publish(*message);
    });
  }

 private:
  ros::Publisher odometry_ = gives<OdometryMessage>("/odom");
};

class ScanFilterNode final : public Working {
 public:
  ScanFilterNode() {
    works_on<run::Reading>("/laser", [this](const std::shared_ptr<const run::Reading>& reading) {
      scans_.publish(*filter_.run(reading->scan, reading->odometry).scan);
    });
  }

 private:
  ScanFilter filter_;
  ros::Publisher scans_ = gives<CleanScan>("/scan", kEachOne);
};

class LocalMapperNode final : public Working {
 public:
  LocalMapperNode() {
    keeps("/odom", odometry_);
    works_on<CleanScan>("/scan", [this](const SharedScan& scan) {
      std::optional<Odometry> wheels;
      if (odometry_) wheels = odometry_of(*odometry_);
      LocalMap map = mapper_.run(*scan).map;
      maps_.publish(surroundings_of(std::move(map), wheels ? &*wheels : nullptr));
    });
  }

 private:
  LocalMapper mapper_;
  std::shared_ptr<const OdometryMessage> odometry_;
  ros::Publisher maps_ = gives<Surroundings>("/local_map");
};

class LocalPlannerNode final : public Working {
 public:
  LocalPlannerNode() {
    keeps("/command", command_);
    works_on<Surroundings>("/local_map", [this](const std::shared_ptr<const Surroundings>& around) {
      if (!around->map) return;
      const Velocity velocity = planner_.run(*around->map, around->odometry, command_ ? *command_ : Command{}).velocity;
      velocities_.publish(to_message(velocity, around->map->stamp));
    });
  }

 private:
  LocalPlanner planner_;
  std::shared_ptr<const Command> command_;
  ros::Publisher velocities_ = gives<TwistMessage>("/cmd_vel");
};

class LocalizerNode final : public Working {
 public:
  LocalizerNode() {
    takes<CleanScan>("/scan", kEachOne, [this](const boost::shared_ptr<const CleanScan>& message) {
      GlobalLocalizer::Result result = localizer_.run({shared_of(message)});
      if (result.news) keyframes_.publish(KeyframesMessage{result.localization});
      fixes_.publish(Fix{std::move(result.localization), message->odometry});
    });
  }

 private:
  GlobalLocalizer localizer_;
  ros::Publisher keyframes_ = gives_and_keeps<KeyframesMessage>("/keyframes");
  ros::Publisher fixes_ = gives<Fix>("/localization");
};

class GlobalMapperNode final : public Working {
 public:
  GlobalMapperNode() {
    works_on<KeyframesMessage>("/keyframes", [this](const std::shared_ptr<const KeyframesMessage>& keyframes) {
      maps_.publish(*mapper_.run(keyframes->localization).map);
    });
  }

 private:
  GlobalMapper mapper_;
  ros::Publisher maps_ = gives_and_keeps<GlobalMap>("/map");
};

class GlobalPlannerNode final : public Working {
 public:
  explicit GlobalPlannerNode(const std::optional<Point>& goal) : goal_(goal) {
    keeps("/map", map_);
    works_on<Fix>("/localization", [this](const std::shared_ptr<const Fix>& fix) {
      if (map_) paths_.publish(planner_.run(*map_, fix->localization, goal_).path);
    });
  }

 private:
  std::optional<Point> goal_;  // none: the robot explores
  GlobalPlanner planner_;
  SharedMap map_;
  ros::Publisher paths_ = gives_and_keeps<Path>("/path");
};

class CommanderNode final : public Working {
 public:
  CommanderNode() {
    keeps("/path", path_);
    works_on<Fix>("/localization", [this](const std::shared_ptr<const Fix>& fix) {
      if (!path_) return;
      const Command command = commander_.run(*path_, fix->localization, fix->odometry).command;
      poses_.publish(to_message(fix->localization.pose_at(fix->odometry), command.stamp));
      commands_.publish(command);
    });
  }

 private:
  NavigationCommand commander_;
  std::shared_ptr<const Path> path_;
  ros::Publisher poses_ = gives<PoseMessage>("/pose");
  ros::Publisher commands_ = gives<Command>("/command");
};

std::unique_ptr<RobotNode> make_global_planner() {
  const auto world = world::read_world(ros::NodeHandle("~").param<std::string>("world", ""));
  if (!world) {
    ROS_ERROR("~world: %s", world.error().message().c_str());
    return nullptr;
  }
  return std::make_unique<GlobalPlannerNode>(world->goal);
}

template <class Node>
std::unique_ptr<RobotNode> make_node() {
  return std::make_unique<Node>();
}

struct Maker {
  const char* name;
  std::unique_ptr<RobotNode> (*make)();
};

constexpr Maker kMakers[] = {
    {"laser_driver", make_node<LaserDriver>},       {"odometry_driver", make_node<OdometryDriver>},
    {"scan_filter", make_node<ScanFilterNode>},     {"local_mapper", make_node<LocalMapperNode>},
    {"local_planner", make_node<LocalPlannerNode>}, {"localizer", make_node<LocalizerNode>},
    {"global_mapper", make_node<GlobalMapperNode>}, {"global_planner", make_global_planner},
    {"commander", make_node<CommanderNode>}};

}  // namespace

std::vector<std::string> robot_node_names() {
  std::vector<std::string> names;
  for (const Maker& maker : kMakers) names.emplace_back(maker.name);
  return names;
}

std::unique_ptr<RobotNode> make_robot_node(const std::string& name) {
  for (const Maker& maker : kMakers) {
    if (maker.name == name) return maker.make();
  }
  return nullptr;
}

}  // namespace ctn::navigation::ros1
