// What a callback costs that does nothing, in nanoseconds, from the queue's spinner to its return: the best of some
// rounds, since other processes can only add to it. The queue has a subscription of /data besides.
//
//   hook_cost FILE     which it is written to: logs go to stdout
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/Int64.h>

#include <algorithm>
#include <chrono>
#include <fstream>

namespace {

constexpr int kRounds = 50;
constexpr int kCallbacks = 2000;

class Nothing final : public ros::CallbackInterface {
 public:
  CallResult call() override { return Success; }
};

void on_data(const std_msgs::Int64::ConstPtr&) {}

}  // namespace

int main(int count, char** arguments) {
  ros::init(count, arguments, "hook_cost");
  ros::NodeHandle handle;
  const ros::Subscriber data = handle.subscribe("/data", 1, on_data);
  ros::CallbackQueue& queue = *ros::getGlobalCallbackQueue();
  const ros::CallbackInterfacePtr nothing(new Nothing);
  double best = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    for (int index = 0; index < kCallbacks; ++index) queue.addCallback(nothing, 1);
    const auto begin = std::chrono::steady_clock::now();
    queue.callAvailable();
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count() / kCallbacks);
  }
  if (count != 2) return 2;
  std::ofstream(arguments[1]) << best << "\n";
  return 0;
}
