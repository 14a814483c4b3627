// A nodelet manager that knows nothing of Catan, with a pipeline of nodelets, for the tests: a camera, whose timer
// makes messages that are shared and not copied, a detector and a follower.
//
//   nodelets --counts FILE --log FILE [--watcher | --reload | --reload-at-work]
//
// With --watcher another one, quicker than the detector, takes its topic and has a timer of its period. It is loaded
// first, so whatever is said of the first callback of that name is said of its. With --reload the detector is unloaded
// four times a second, now and then in the middle of its work, and loaded again, with its queues elsewhere; with
// --reload-at-work its timer's callback is at work most of the time.
//
// What was counted is written to FILE, as JSON, ten times a second: calls of the follower and of the watcher, callbacks
// of one nodelet that overlapped, messages that were copied on their way, how often the detector was loaded again, and
// how often it went while a callback of it was under way. Each message that the follower gets is a line of the log.
#include <nodelet/loader.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <std_msgs/Int64.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>

#include <boost/make_shared.hpp>

#include "ros1/test/burn.h"

namespace {

std::string g_counts_file;
std::string g_log;
double g_timer_work = 0.5;  // the detector's, in ms
std::atomic<long> g_calls{0};
std::atomic<long> g_watched{0};
std::atomic<long> g_reloaded{0};
std::atomic<long> g_gone_inside{0};
std::atomic<long> g_overlaps{0};
std::atomic<long> g_copies{0};

// Where the camera's last messages lie.
class Places {
 public:
  void note(const std_msgs::Int64& message) {
    places_[static_cast<std::size_t>(message.data) % places_.size()].store(&message);
  }
  bool is_at(const std_msgs::Int64& message) const {
    return places_[static_cast<std::size_t>(message.data) % places_.size()].load() == &message;
  }

 private:
  std::array<std::atomic<const void*>, 256> places_{};
};

Places g_places;

class Camera : public nodelet::Nodelet {
  void onInit() override {
    out_ = getNodeHandle().advertise<std_msgs::Int64>("/images", 10);
    timer_ = getNodeHandle().createTimer(ros::Duration(0.02), [this](const ros::TimerEvent&) {
      const auto message = boost::make_shared<std_msgs::Int64>();
      message->data = ++made_;
      g_places.note(*message);
      out_.publish(message);
    });
  }

  ros::Publisher out_;
  ros::Timer timer_;
  long made_ = 0;
};

// Both of its callbacks are of one queue, which calls one at a time.
class Detector : public nodelet::Nodelet {
 public:
  // Works for so long, in ms, on each image. What it makes of it goes to topic `out`; if that is empty, it only
  // watches.
  Detector(double work, std::string out) : work_(work), topic_(std::move(out)) {}
  ~Detector() override {
    in_.shutdown();
    timer_.stop();
    if (inside_ > 0) ++g_gone_inside;
  }

 private:
  void onInit() override {
    if (!topic_.empty()) out_ = getNodeHandle().advertise<std_msgs::Int64>(topic_, 10);
    in_ = getNodeHandle().subscribe<std_msgs::Int64>("/images", 10, [this](const std_msgs::Int64::ConstPtr& message) {
      if (++inside_ > 1) ++g_overlaps;
      if (!g_places.is_at(*message)) ++g_copies;
      burn(work_);
      if (topic_.empty()) {
        ++g_watched;
      } else {
        out_.publish(boost::make_shared<std_msgs::Int64>(*message));
      }
      --inside_;
    });
    timer_ = getNodeHandle().createTimer(ros::Duration(0.005), [this](const ros::TimerEvent&) {
      if (++inside_ > 1) ++g_overlaps;
      burn(g_timer_work);
      --inside_;
    });
  }

  const double work_;
  const std::string topic_;
  ros::Publisher out_;
  ros::Subscriber in_;
  ros::Timer timer_;
  std::atomic<int> inside_{0};
};

class Follower : public nodelet::Nodelet {
  static void on_thing(const std_msgs::Int64::ConstPtr& message) {
    std::ofstream(g_log, std::ios::app) << message->data << "\n";
    ++g_calls;
  }
  void onInit() override { in_ = getMTNodeHandle().subscribe<std_msgs::Int64>("/things", 10, &Follower::on_thing); }

  ros::Subscriber in_;
};

// Has queues, and nothing else.
class Filler : public nodelet::Nodelet {
  void onInit() override {}
};

boost::shared_ptr<nodelet::Nodelet> make(const std::string& type) {
  if (type == "camera") return boost::make_shared<Camera>();
  if (type == "detector") return boost::make_shared<Detector>(5.0, "/things");
  if (type == "watcher") return boost::make_shared<Detector>(1.0, "");
  if (type == "filler") return boost::make_shared<Filler>();
  return boost::make_shared<Follower>();
}

// Others take the place of the queues that it had before it gets its new ones.
void load_again(nodelet::Loader& loader) {
  loader.unload("/detector");
  loader.load("/filler_" + std::to_string(g_reloaded), "filler", {}, {});
  if (loader.load("/detector", "detector", {}, {})) ++g_reloaded;
}

void write_counts_of_all(const ros::SteadyTimerEvent&) {
  const std::string written = g_counts_file + ".new";
  std::ofstream(written) << "{\"calls\": " << g_calls << ", \"watched\": " << g_watched
                         << ", \"reloaded\": " << g_reloaded << ", \"gone_inside\": " << g_gone_inside
                         << ", \"overlaps\": " << g_overlaps << ", \"copies\": " << g_copies << "}";
  std::rename(written.c_str(), g_counts_file.c_str());
}

}  // namespace

int main(int count, char** arguments) {
  ros::init(count, arguments, "manager");
  if (count != 5 && count != 6) return 2;
  g_counts_file = arguments[2];
  g_log = arguments[4];
  nodelet::Loader loader(boost::function<boost::shared_ptr<nodelet::Nodelet>(const std::string&)>{make});
  const std::string option = count == 6 ? arguments[5] : "";
  const bool reloads = option.rfind("--reload", 0) == 0;
  if (option == "--reload-at-work") g_timer_work = 6.0;
  if (option == "--watcher" && !loader.load("/watcher", "watcher", {}, {})) return 1;
  for (const char* const name : {"camera", "detector", "follower"}) {
    if (!loader.load(std::string("/") + name, name, {}, {})) return 1;
  }
  ros::NodeHandle handle;
  const ros::SteadyTimer writer = handle.createSteadyTimer(ros::WallDuration(0.1), write_counts_of_all);
  ros::SteadyTimer again = handle.createSteadyTimer(
      ros::WallDuration(0.25), [&loader](const ros::SteadyTimerEvent&) { load_again(loader); }, false, reloads);
  ros::spin();
  return 0;
}
