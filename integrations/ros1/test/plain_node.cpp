// A ROS program that knows nothing of Catan, for the tests: what it does is said on its command line.
//
//   plain_node NAME [--in TOPIC] [--out TOPIC] [--timer MS] [--burn MS] [--beside TOPIC] [--spin-once] [--threads N]
//              [--unsubscribe-after N] [--throw-every N]
//              [--service SERVICE] [--ask SERVICE] [--wrapped-queue] [--counts FILE] [--log FILE] [--queue N]
//              [--loop-hz HZ] [--loop-wait SECONDS] [--wait-first] [--once-first] [--simulated-time] [--restarts N]
//              [--subscribe-again] [--stop-inside] [--strings KB] [--sleep MS]
//
// With --unsubscribe-after the callback of --in unsubscribes itself at that message. With --throw-every each so many
// calls of it or of the timer's end with an exception; what comes out of --spin-once's spinOnce() is counted.
//
// A message on --in, a request of --service, or the timer, makes it burn CPU time and publish what it has counted, or
// got, on --out. With --ask the timer asks that service instead, and an answer is counted. A message on --beside is
// counted by another callback. What was counted is written to the file of --counts, as JSON, ten times a second; each
// message of --in to that of --log, one a line. --queue is that of --in; --loop-hz how often --spin-once spins. With
// --loop-wait a loop of its own waits for callbacks, so long each time, and works on what they have stored. With
// --wait-first it waits for a message before it subscribes, with --once-first it has a timer that is due once before
// the other, of the same period. --restarts: so often it starts four spinner threads, and stops them, before it spins.
// With --subscribe-again it assigns another subscription of --in to the first. With --stop-inside the callback of the
// timer or the service waits for a lock, and who has got that stops the timer or the service meanwhile. With --strings
// what goes over --in and --out are strings of so many kilobytes. With --sleep it sleeps when it has burnt.
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <roscpp/Empty.h>
#include <std_msgs/Int64.h>
#include <std_msgs/String.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ros1/test/burn.h"

namespace {

struct Asked {
  int unsubscribe_after = 0, throw_every = 0;
  std::string in, out, beside, service, ask, counts, log;
  double timer_ms = 0.0, burn_ms = 0.0, sleep_ms = 0.0, loop_hz = 200.0, loop_wait = 0.0;
  bool spin_once = false, wrapped_queue = false, wait_first = false, once_first = false, simulated_time = false;
  bool subscribe_again = false, stop_inside = false;
  int threads = 1, queue = 10, restarts = 0;
  std::size_t string_kb = 0;
};

struct Counts {
  std::atomic<long> calls{0}, beside{0}, overlaps{0}, newest{0}, backward{0}, once{0}, stopped{0}, thrown{0};
  std::atomic<long> worked{0}, loops{0};  // of --loop-wait: on new values, and rounds
  std::atomic<long> sleeps{0};            // of the thread that spins
  // Of the timer's calls but the first: the time since the one before, as it is told; and from first to last.
  std::atomic<long> told_ms{0}, passed_ms{0};
};

Asked g_asked;
Counts g_counts;
std::atomic<int> g_inside{0};
std::atomic<bool> g_is_called{false};
std::mutex g_mutex;  // of --stop-inside
ros::Publisher g_out;
ros::Subscriber g_in;

class Inside {
 public:
  Inside() {
    if (++g_inside > 1) ++g_counts.overlaps;
  }
  ~Inside() { --g_inside; }
};

void publish(long value) {
  if (g_asked.string_kb > 0) {
    std_msgs::String message;
    message.data.assign(1024 * g_asked.string_kb, 'x');
    return g_out.publish(message);
  }
  std_msgs::Int64 message;
  message.data = value;
  g_out.publish(message);
}

void work(long value) {
  const Inside inside;
  g_is_called = true;
  if (g_asked.stop_inside) const std::lock_guard lock(g_mutex);
  burn(g_asked.burn_ms);
  if (g_asked.sleep_ms > 0.0) std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(g_asked.sleep_ms));
  if (g_out) publish(value);
  ++g_counts.calls;
}

// At the end of a call that was counted.
void throw_now_and_then() {
  if (g_asked.throw_every > 0 && g_counts.calls % g_asked.throw_every == 0) throw std::runtime_error("of the callback");
}

void on_message(const std_msgs::Int64::ConstPtr& message) {
  if (message->data < g_counts.newest.load()) ++g_counts.backward;
  g_counts.newest = message->data;
  if (!g_asked.log.empty()) std::ofstream(g_asked.log, std::ios::app) << message->data << "\n";
  if (g_asked.unsubscribe_after > 0 && g_counts.calls + 1 == g_asked.unsubscribe_after) g_in.shutdown();
  work(message->data);
  throw_now_and_then();
}

void on_string(const std_msgs::String::ConstPtr&) { work(++g_counts.newest); }

void on_beside(const std_msgs::Int64::ConstPtr&) {
  const Inside inside;
  ++g_counts.beside;
}

bool on_request(roscpp::Empty::Request&, roscpp::Empty::Response&) {
  work(++g_counts.newest);
  return true;
}

void ask() {
  roscpp::Empty empty;
  if (ros::service::call(g_asked.ask, empty)) ++g_counts.calls;
}

void on_timer(const ros::TimerEvent& event) {
  static double told = 0.0;
  static const double kFirst = event.current_real.toSec();
  const double now = event.current_real.toSec();
  if (now > kFirst) told += now - event.last_real.toSec();
  g_counts.told_ms = std::lround(1e3 * told);
  g_counts.passed_ms = std::lround(1e3 * (now - kFirst));
  g_asked.ask.empty() ? work(++g_counts.newest) : ask();
  throw_now_and_then();
}

// How often the calling thread has slept.
long sleeps() {
  rusage used{};
  ::getrusage(RUSAGE_THREAD, &used);
  return used.ru_nvcsw;
}

void write_counts() {
  const std::string written = g_asked.counts + ".new";
  {
    std::ofstream file(written);
    file << "{\"calls\": " << g_counts.calls << ", \"beside\": " << g_counts.beside
         << ", \"overlaps\": " << g_counts.overlaps << ", \"newest\": " << g_counts.newest
         << ", \"backward\": " << g_counts.backward << ", \"once\": " << g_counts.once
         << ", \"stopped\": " << g_counts.stopped << ", \"thrown\": " << g_counts.thrown
         << ", \"worked\": " << g_counts.worked << ", \"loops\": " << g_counts.loops
         << ", \"sleeps\": " << g_counts.sleeps << ", \"told_ms\": " << g_counts.told_ms
         << ", \"passed_ms\": " << g_counts.passed_ms << "}";
  }
  std::rename(written.c_str(), g_asked.counts.c_str());
}

bool* flag_of(const std::string& option) {
  if (option == "--spin-once") return &g_asked.spin_once;
  if (option == "--wrapped-queue") return &g_asked.wrapped_queue;
  if (option == "--wait-first") return &g_asked.wait_first;
  if (option == "--once-first") return &g_asked.once_first;
  if (option == "--subscribe-again") return &g_asked.subscribe_again;
  if (option == "--stop-inside") return &g_asked.stop_inside;
  if (option == "--simulated-time") return &g_asked.simulated_time;
  return nullptr;
}

bool read(const std::vector<std::string>& arguments) {
  for (std::size_t index = 1; index < arguments.size(); ++index) {
    const std::string& option = arguments[index];
    if (bool* const flag = flag_of(option)) {
      *flag = true;
      continue;
    }
    if (++index == arguments.size()) return false;
    const std::string& value = arguments[index];
    if (option == "--in") {
      g_asked.in = value;
    } else if (option == "--out") {
      g_asked.out = value;
    } else if (option == "--beside") {
      g_asked.beside = value;
    } else if (option == "--service") {
      g_asked.service = value;
    } else if (option == "--ask") {
      g_asked.ask = value;
    } else if (option == "--counts") {
      g_asked.counts = value;
    } else if (option == "--log") {
      g_asked.log = value;
    } else if (option == "--unsubscribe-after") {
      g_asked.unsubscribe_after = std::stoi(value);
    } else if (option == "--throw-every") {
      g_asked.throw_every = std::stoi(value);
    } else if (option == "--timer") {
      g_asked.timer_ms = std::stod(value);
    } else if (option == "--burn") {
      g_asked.burn_ms = std::stod(value);
    } else if (option == "--sleep") {
      g_asked.sleep_ms = std::stod(value);
    } else if (option == "--queue") {
      g_asked.queue = std::stoi(value);
    } else if (option == "--loop-hz") {
      g_asked.loop_hz = std::stod(value);
    } else if (option == "--loop-wait") {
      g_asked.loop_wait = std::stod(value);
    } else if (option == "--restarts") {
      g_asked.restarts = std::stoi(value);
    } else if (option == "--strings") {
      g_asked.string_kb = std::stoul(value);
    } else if (option == "--threads") {
      g_asked.threads = std::stoi(value);
    } else {
      return false;
    }
  }
  return true;
}

// A queue of another class, as nodelets have.
class WrappedQueue final : public ros::CallbackQueueInterface {
 public:
  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t id) override {
    queue_.addCallback(callback, id);
  }
  void removeByID(std::uint64_t id) override { queue_.removeByID(id); }
  void spin() {
    while (ros::ok()) queue_.callAvailable(ros::WallDuration(0.1));
  }

 private:
  ros::CallbackQueue queue_;
};

WrappedQueue g_queue;

void start_and_stop_spinners() {
  ros::AsyncSpinner spinners(4);
  spinners.start();
  std::this_thread::sleep_for(std::chrono::milliseconds{50});  // so that each has begun
  spinners.stop();
}

// It has got what a callback waits for that is under way.
void stop_inside(ros::Timer& timer, ros::ServiceServer& service) {
  const std::lock_guard lock(g_mutex);
  while (ros::ok() && !g_is_called) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  timer.stop();
  service.shutdown();
  ++g_counts.stopped;
}

void spin_once() {
  try {
    ros::spinOnce();
  } catch (const std::runtime_error&) {
    ++g_counts.thrown;
  }
}

void loop() {
  for (long known = 0; ros::ok(); ++g_counts.loops) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(g_asked.loop_wait));
    if (std::exchange(known, g_counts.newest.load()) != g_counts.newest) ++g_counts.worked;
  }
}

void spin() {
  for (int round = 0; round < g_asked.restarts; ++round) start_and_stop_spinners();
  if (g_asked.wrapped_queue) {
    ros::AsyncSpinner others(1);
    others.start();
    g_queue.spin();
  } else if (g_asked.spin_once) {
    ros::WallRate rate(g_asked.loop_hz);
    while (ros::ok()) {
      {
        const Inside inside;
        burn(0.5);
      }
      spin_once();
      rate.sleep();
    }
  } else if (g_asked.loop_wait > 0.0) {
    loop();
  } else if (g_asked.threads > 1) {
    ros::MultiThreadedSpinner(static_cast<std::uint32_t>(g_asked.threads)).spin();
  } else {
    ros::spin();
  }
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<std::string> rest;
  ros::removeROSArgs(count, arguments, rest);
  rest.erase(rest.begin());
  if (rest.empty() || !read(rest)) return 2;
  ros::init(count, arguments, rest[0]);
  if (g_asked.simulated_time) ros::param::set("/use_sim_time", true);
  ros::NodeHandle handle;
  if (g_asked.wait_first) ros::topic::waitForMessage<std_msgs::Int64>(g_asked.in, handle);
  if (g_asked.wrapped_queue) handle.setCallbackQueue(&g_queue);
  const bool strings = g_asked.string_kb > 0;
  if (!g_asked.out.empty()) {
    g_out = strings ? handle.advertise<std_msgs::String>(g_asked.out, 10)
                    : handle.advertise<std_msgs::Int64>(g_asked.out, 10);
  }
  ros::Subscriber beside;
  const auto subscribe = [&] {
    const auto queue = static_cast<std::uint32_t>(g_asked.queue);
    return strings ? handle.subscribe(g_asked.in, queue, on_string) : handle.subscribe(g_asked.in, queue, on_message);
  };
  if (!g_asked.in.empty()) g_in = subscribe();
  if (g_asked.subscribe_again) g_in = subscribe();
  if (!g_asked.beside.empty()) beside = handle.subscribe(g_asked.beside, 100, on_beside);
  ros::ServiceServer service;
  if (!g_asked.service.empty()) service = handle.advertiseService(g_asked.service, on_request);
  ros::Timer once, timer;
  const ros::Duration period(g_asked.timer_ms * 1e-3);
  if (g_asked.once_first)
    once = handle.createTimer(
        period, [](const ros::TimerEvent&) { ++g_counts.once; }, true);
  if (g_asked.timer_ms > 0.0) timer = handle.createTimer(period, on_timer);
  // What it writes is no callback's: to replace a file may take as long as a callback's work.
  std::thread writer([] {
    while (ros::ok() && !g_asked.counts.empty()) {
      std::this_thread::sleep_for(std::chrono::milliseconds{100});
      write_counts();
    }
  });
  ros::SteadyTimer light;
  const auto note_sleeps = [](const ros::SteadyTimerEvent&) { g_counts.sleeps = sleeps(); };
  if (g_asked.loop_wait <= 0.0) light = handle.createSteadyTimer(ros::WallDuration(0.1), note_sleeps);
  std::thread stopper;
  if (g_asked.stop_inside) stopper = std::thread([&] { stop_inside(timer, service); });
  spin();
  ros::shutdown();
  writer.join();
  if (stopper.joinable()) stopper.join();
  g_in = {};  // while there is the node that it is of
  return 0;
}
