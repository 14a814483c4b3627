// An application in one process, scheduled by Catan.
//
//   auto session = ctn::Session::open("app.yaml", options);           // reads the app file
//   auto& frames = session->channel<Image>("camera", "detect");       // one channel an edge
//   session->node("camera", [&](ctn::Run& run) { frames.write(run, grab()); });
//   session->node("detect", [&](ctn::Run& run) { if (auto* f = frames.read(run)) look(*f); });
//   session->start();   ...   session->stop();
//
// Each scheduled node has a thread that Catan makes; its function is called once a run: a head's on its trigger,
// another's when its predecessor in the subchain has ended. What a run writes becomes visible when it ends. An
// unscheduled node's function is called once every period of the node; without a period, when the unscheduled node that
// it follows has given an output. External nodes have none.
//
// Policies:
//   "catan"          what is used if nothing is said: the planner that the app file names, "auto" if it names none
//   "auto"           plans rates, cores, shares of cores and levels from measured compute times, again and again
//   "paper"          the planner of the paper, with fixed frames, to compare with
//   "static:FILE"    follows a plan that `catan plan --json` (or planning.h) made, and never revises it
//   "rates-of:FILE"  has the rates of such a plan set by hand: whole subchains, under ordinary scheduling on all CPUs,
//                    whatever the plan says of cores and priorities
//   "default"        triggers nodes at their `fallback_rate`, under ordinary scheduling; a node of a subchain that has
//                    none is triggered by the one before it
//   "rate:HZ"        whole subchains at the `fallback_rate` of their heads, but at a given rate where these are sources
//   "fifo"           as "default", but at fixed real-time priorities in the order of stealing (by weight)
//   "picas:COSTS"    as "default", but each subchain on one core, at chain-aware fixed priorities
//   "davare:COSTS", "verucchi:COSTS"   rates, cores and fixed priorities by published methods; COSTS: a cost file, or
//                    the record of a run
// CPUs that go offline, or that are taken from the process while the session runs (its cpuset, or `taskset` on its main
// thread or on all threads), are not planned with until they are back.
// The last seconds of what happens are kept in memory (docs/flight-recorder.md): `catan top` shows them, save_flight()
// makes a record of them.
// Without the permission to set real-time levels "catan" plans and triggers but does not prioritise (rates only), and
// says so in the snapshot, in the record and to on_notice.
//
// A forked child has a copy of the session, which is none: there stop(), node() and the destructor do nothing, a
// snapshot is empty, a channel leads nowhere, and all else is an error (kCaller). The session goes on in the process
// that opened it. A child that runs another program, by exec, need not know.
//
// Thread safety: open, node, channel, queue, start, stop from one thread; change, snapshot, save_flight and
// adopt_this_thread from any; tick from any, but for one node from one at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "catan/changes.h"
#include "catan/channel.h"
#include "catan/result.h"
#include "catan/run.h"
#include "catan/snapshot.h"

namespace ctn {

struct SessionOptions {
  std::string policy = "catan";
  std::vector<int> cpus;                              // CPUs that nodes may use; empty: all that this process may use
  std::string record;                                 // path of the record to write; empty: none
  std::string note;                                   // kept in the record
  bool stealing = true;                               // false: no unfinished subchain goes on in another's slot
  bool replan = true;                                 // false: the first plan for which all nodes have run stays
  std::optional<bool> fixed_frames{};                 // frames fixed or elastic, in place of the app file's
  int flight_recorder_mib = 8;                        // memory in which the last seconds are kept; 0: they are not
  std::function<void(const std::string&)> on_notice;  // called by a thread of its own, ordinary; may block
};

class Session {
 public:
  // Errors: all that is wrong with the file (kCaller), CPUs that are not there (kCaller), a record that cannot be made.
  static Result<Session> open(const std::string& app_file, const SessionOptions& options);

  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();  // stops, but in a forked child

  // What `name` does in a run. A name that the app has not, an external node, or a second function are reported by
  // start(). Once it has started, neither this nor channel() changes anything: a notice says so (`too-late`), and
  // stop() reports it.
  void node(std::string_view name, std::function<void(Run&)> body);

  // The channel of the edge from -> to, made on first use; it lives as long as the session. An edge that is not there,
  // one into a node of the other kind of input, or another T than before are reported by start(), all at once; until
  // then the channel returned leads nowhere.
  template <class T>
  Channel<T>& channel(std::string_view from, std::string_view to) {
    return open_channel<Channel<T>>(from, to, false);
  }
  template <class T>
  QueueChannel<T>& queue(std::string_view from, std::string_view to) {
    return open_channel<QueueChannel<T>>(from, to, true);
  }

  // Called by a thread that works for a node in addition to the node's own: from now on it runs at the node's level, on
  // its cores, and its CPU time counts as the node's. Lasts until the thread ends. Errors: no such node; too many
  // threads (64 a node).
  Status adopt_this_thread(std::string_view node);

  // The clock of an external node with a `period`, a display say, ticked at that instant. Once some ticks are known,
  // chains that end or begin there are measured by them, and phases may be planned against them. Not every tick must be
  // told, nor at once. Costs less than a microsecond, and never waits. Errors: no such node, or it has no clock
  // (kCaller).
  Status tick(std::string_view node, std::chrono::steady_clock::time_point at = std::chrono::steady_clock::now());

  // Starts all threads. Errors: everything that was wrong with node() and channel() calls, a node without a function
  // (kCaller); a plan that cannot be made; CPUs or threads that cannot be had (kEnvironment).
  Status start();
  // Waits for runs that are under way and until on_notice has been told all, restores scheduling, closes the record.
  // May be called twice. Errors: it is called by a node's function or on_notice (kCaller), and then does nothing; the
  // first error of the record; calls of node() and channel() that came too late (kCaller).
  Status stop();

  // While it runs: other weights, bounds or CPUs from now on, all of them or, where anything is wrong, none. A plan for
  // them is made at once, in the housekeeping thread; the call does not wait for it. What was changed is in the record,
  // in the snapshot and told as a notice (`changed`); the app file stays as it is. Errors: all that is wrong, as with
  // an app file (kCaller); a policy that never plans again; it does not run.
  Status change(const Changes& changes);

  Snapshot snapshot() const;

  // Saves the last seconds, which are always kept in memory, as a new record, to be read as any other (`catan report`);
  // `why` is told in it. What a run has just done is there after 50 ms. Takes milliseconds, of the calling thread
  // alone: not for a node's function. Errors: it was not started; a file that is there already or cannot be made; no
  // flight recorder (kCaller, kEnvironment).
  Status save_flight(const std::string& path, const std::string& why = "asked") const;

 private:
  friend class SessionAccess;  // the command
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make);

  template <class C>
  C& open_channel(std::string_view from, std::string_view to, bool queue) {
    return static_cast<C&>(open_channel(from, to, queue, typeid(C), make_channel<C>));
  }

  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn
