// Nodes of an app that `catan serve` schedules, in a process of their own.
//
//   auto client = ctn::Client::connect();                    // the server that CATAN_SOCKET names
//   client->node("LM", [&](ctn::Run& run) { look(newest_scan()); });
//   client->start();   ...   client->stop();
//
// One process runs one node or several, and an app's nodes may be spread over as many processes as one likes. How data
// gets from one to another is the app's affair (ROS, shared memory, a socket); nodes of the same process may use the
// channels here. Needs no privilege: the server gives threads their CPUs and levels.
//
// Two ways to run a node:
//   node(NAME, function)   Catan makes a thread, which calls the function once a run, as a Session does
//   attach(NAME)           the calling thread becomes the node's and says itself when its runs begin and end: for
//                          frameworks that have threads of their own
//
// All threads of a process that runs one node belong to it, also those that libraries make; in a process that runs
// several, a thread that works for one of them calls adopt_this_thread(), and share_thread() names one that works for
// all.
//
// When the server ends or is killed, nodes go on by themselves, at the rates that it planned last, under ordinary
// scheduling; on_notice is told. As soon as there is a server again (of the same app), they are its.
//
// A forked child has a copy of the client, which is none: there stop(), node() and the destructor do nothing, served()
// is false, a channel leads nowhere, and all else is an error (kCaller). A handle from attach() is not to be used
// there. The nodes go on in the process that connected.
//
// Thread safety: connect, node, channel, queue, start, stop from one thread; attach and adopt_this_thread from the
// thread concerned, between start and stop. on_notice is called by a thread of its own, with no lock held, and may call
// all of them; stop alone waits for it. Called by it, or by a node's function, stop returns at once, and what it does
// goes on meanwhile. Else all notices have been told when stop returns.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <typeindex>

#include "catan/awaited.h"
#include "catan/channel.h"
#include "catan/result.h"
#include "catan/run.h"

namespace ctn {

struct ClientOptions {
  std::string socket;          // of the server; empty: what CATAN_SOCKET names, else the usual one of `app`
  std::string app;             // name of the app; checked, if given
  double wait_seconds = 10.0;  // for a server that is not there yet
  std::function<void(const std::string&)> on_notice;  // called by a thread of its own, ordinary; may block
};

// A node whose runs its own thread begins and ends:
//   while (node.wait()) { node.begin(run); ...; node.end(run); }
class AttachedNode {
 public:
  // Blocks until the node is to run; false: the client was stopped. An unscheduled node waits only if it has no period
  // of its own, for the output of the node that it follows.
  bool wait();
  // The same for a program that can do its part of the app without triggers, too: it is also told, at each call and at
  // once, that the server has let go of the node's subchain. The server does so when a node of it has been missing for
  // a second. To others, and where a node follows another, nothing changes: they wait.
  Awaited await();
  // Blocks as long as the server has let go of the node's subchain; false: the client was stopped.
  bool await_complete();
  // `run` is the same object every time.
  void begin(Run& run);
  // Between the two: what the run takes from node `from` is outputs of its runs `first` to `last` (Run::number()
  // there), where messages say so; else it is taken to be the newest that was given when the run began. What has not
  // been given yet does not count, nor does it where `from` is no predecessor, or gives over a channel.
  void take(Run& run, std::string_view from, std::uint64_t first, std::uint64_t last);
  void end(Run& run);

 private:
  friend class Client;
  explicit AttachedNode(void* port) : port_(port) {}
  void* port_;
};

class Client {
 public:
  // Waits for the server as long as the options say. Errors: there is none, it refuses this process, or serves another
  // app; no thread can be made (kEnvironment).
  static Result<Client> connect(const ClientOptions& options = {});

  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();  // stops, but in a forked child

  // As those of Session. Mistakes are reported by start(), and calls after it by a notice (`too-late`) alone.
  void node(std::string_view name, std::function<void(Run&)> body);
  template <class T>
  Channel<T>& channel(std::string_view from, std::string_view to) {
    return open_channel<Channel<T>>(from, to, false);
  }
  template <class T>
  QueueChannel<T>& queue(std::string_view from, std::string_view to) {
    return open_channel<QueueChannel<T>>(from, to, true);
  }

  // Starts the nodes' threads and registers them. Errors: everything that was wrong with node() and channel() calls, a
  // node that another process runs, threads that cannot be had. After such an error of threads or nodes it is stopped.
  Status start();
  // Registers the calling thread as the node's. The handle is good as long as this client, also after stop(). Errors:
  // as start(), and that there is no server at this moment.
  Result<AttachedNode> attach(std::string_view name);
  Status adopt_this_thread(std::string_view node);
  // A thread of this process, by the number that gettid() gives it, works for all nodes of it: its middleware's, say.
  // It counts as a thread of the node that weighs most of those that this process runs, so that it is no more urgent
  // than that, and its CPU time is in what that node costs. From any thread; does not wait for the server, which is
  // told soon, or when there is one. Errors: a thread of another process, kCaller.
  Status share_thread(int thread);
  // Ends waits, lets runs that are under way end, leaves. Attached threads are to return by themselves.
  void stop();

  // Whether a server is there at this moment.
  bool served() const;

 private:
  class Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  ChannelBase& open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                            MakeChannel make);

  template <class C>
  C& open_channel(std::string_view from, std::string_view to, bool queue) {
    return static_cast<C&>(open_channel(from, to, queue, typeid(C), make_channel<C>));
  }

  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn
