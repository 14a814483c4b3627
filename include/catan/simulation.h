// An application in virtual time: the same functions as in a session, the same policies, planner and controllers, on a
// machine that is a model. What a run costs is what its function charges for the work that it did, or else is drawn
// from a cost file, whatever the function takes to compute. So a whole closed loop (robot, world, collisions) can be
// tried on any number of cores, slower or faster than real time, with the same result each time.
//
//   auto simulation = ctn::Simulation::open("app.yaml", {.costs = "costs.yaml", .cores = 2});
//   auto& sights = simulation->channel<double>("look", "steer");
//   simulation->node("look", [&](ctn::Run& run) { sights.write(run, world.at(simulation->now())); });
//   simulation->node("steer", [&](ctn::Run& run) { if (auto* sight = sights.read(run)) wanted = -*sight; });
//   simulation->on_effect("steer", [&](ctn::Run&) { world.turn(simulation->now(), wanted); });
//   simulation->run_for(std::chrono::seconds{60});   ...   simulation->snapshot();
//
// A function is called when a run of its node begins, at that instant of virtual time, and sees the inputs and the
// world as they are then. What it writes reaches other nodes when the run ends, which is when on_effect's function is
// called: there belongs what a run does to the world, as a motor's command. No time passes while either is called. A
// world that moves by itself is advanced to now() by the functions that look at it or act on it.
//
// Costs. A function that calls Run::charge() says what its run costs: how much work there was (cells, particles,
// candidates: counted) times a factor that was measured once. So costs come out of the world, and grow as it does.
//
//   simulation->node("map", [&](ctn::Run& run) { run.charge(map.add(*scans.read(run)) * 12ns); });    // cells touched
//
// That is CPU time on a core of speed 1, all threads of the run added up: it is multiplied by `slowdown`, divided by
// the speed of the core's kind where the app file gives one, and shared evenly by the threads that the run works on.
// What Catan itself costs (SimulationOptions::ideal) comes on top, and so does a wait that the cost file says. The run
// is in the mode that Run::set_mode() says, or in the first. A run that is not charged costs what the cost file says,
// with all that this has (modes, spikes, growth, what items of batches add), in a mode that is drawn, whatever
// set_mode() says; a node may charge in some runs only. Of nodes that charge each of their runs nothing need be in the
// file, and where all do, none is needed. To be charged in the function of node(), since the cost has to be known when
// the run begins.
//
// The policies are those of session.h. The same app, costs and options give the same result to the bit, on every
// machine, as far as the functions themselves do. How far the model is from real runs: docs/plants-in-the-loop.md.
//
// Thread safety: none: one thread uses it, and calls all functions. Several simulations may run at once, each in a
// thread of its own. Units: virtual time since the start, which is 0, in nanoseconds.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "catan/channel.h"
#include "catan/result.h"
#include "catan/run.h"
#include "catan/snapshot.h"

namespace ctn {

// A clock that is not Catan's: when an external node with a `period` ticks, or a timer begins runs of an unscheduled
// node. What the app file says of its period is what it is planned with; this is what it does: a phase, and a drift.
struct SimulatedClock {
  std::string node;
  std::chrono::nanoseconds first{};  // tick, since the start
  std::chrono::nanoseconds period{};
};

struct SimulationOptions {
  std::string costs;                   // path of the cost file (docs/cost-file.md): what runs cost that are not
                                       // charged; empty: all are
  double slowdown = 1.0;               // every run costs so many times as much, as on a slower machine
  std::string policy = "catan";        // as in SessionOptions
  int cores = 0;                       // that nodes may use; 0: those that the app file lists, else 1
  std::uint64_t seed = 1;              // of the costs' draws
  bool stealing = true;                // as in SessionOptions
  bool replan = true;                  // as in SessionOptions
  std::optional<bool> fixed_frames{};  // as in SessionOptions
  bool real_time = true;               // false: real-time levels are not permitted (rates only)
  std::string record;                  // path of a record to write, as a session does; empty: none
  std::string note;                    // kept in the record
  bool ideal = false;                  // true: scheduling itself costs no time, and real-time threads have no limit
  // Of other nodes: external ones tick at a phase that is always the same, unscheduled ones begin a period after the
  // start.
  std::vector<SimulatedClock> clocks{};
  // By node: beyond `slowdown`, each of its runs costs so many times as much, also where it is charged. So a simulation
  // is like the machine on which it was measured what runs cost beside what they are charged (Run::charged()).
  std::map<std::string, double> slowdowns{};
};

class Simulation {
 public:
  // Errors (kCaller): all that is wrong with the two files; a policy that there is not, or that cannot schedule this
  // app; another number of cores than the app lists, or more than can be simulated; a slowdown that is not above 0, or
  // of a node that there is not; a clock of a node that has none, or twice of one, or that ticks before the start or at
  // no period; a record that cannot be made.
  static Result<Simulation> open(const std::string& app_file, const SimulationOptions& options);

  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  // What `name` does in a run. A node that is given none does nothing but take its time. A name that the app has not,
  // an external node, a second function, or a call after the first run_for() are reported by the next run_for().
  void node(std::string_view name, std::function<void(Run&)> body);
  // What `name` does to the world when a run ends, with the same Run as in its function, which is where channels are
  // read. Mistakes as with node().
  void on_effect(std::string_view name, std::function<void(Run&)> effect);

  // The channel of the edge from -> to, as in a session; mistakes are reported by the next run_for(). Where a node has
  // no function, or an edge no channel, the consumer's runs use what came over it all the same, as far as response
  // times go.
  template <class T>
  Channel<T>& channel(std::string_view from, std::string_view to) {
    return open_channel<Channel<T>>(from, to, false);
  }
  template <class T>
  QueueChannel<T>& queue(std::string_view from, std::string_view to) {
    return open_channel<QueueChannel<T>>(from, to, true);
  }

  std::chrono::nanoseconds now() const;
  // When what snapshots show begins: after the bootstrap and a little more, as in a session.
  std::chrono::nanoseconds warm_from() const;

  // Lets so much more time pass. Many short calls come to the same as a long one. Errors (kCaller): everything that was
  // wrong with the calls above; a duration below 0; a call from within a node's function; a node of which neither a
  // function nor the cost file says what its runs cost. From runs, where time then stops: one that was not charged, of
  // a node that the cost file does not have; a charge below 0, or in the function of on_effect(); a mode that the app
  // has not.
  Status run_for(std::chrono::nanoseconds duration);

  // Closes the record. May be called twice; what comes later is not recorded. Errors: what could not be written.
  Status finish();

  // What was measured up to now, as a session tells it. Not from within a node's function. Percentiles are of all
  // samples, and exact to 0.4 %. What a simulation cannot know: starved_ms is always 0; nor can anything be changed
  // while it runs, so `changes` is 0.
  Snapshot snapshot() const;

 private:
  class Impl;
  explicit Simulation(std::unique_ptr<Impl> impl);
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make);

  template <class C>
  C& open_channel(std::string_view from, std::string_view to, bool queue) {
    return static_cast<C&>(open_channel(from, to, queue, typeid(C), make_channel<C>));
  }

  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn
