// What a framework calls whose nodes all live in one program and share messages there: of a loop, of a topic and of a
// callback. For the framework's own compilers this is C++17, and needs the standard library alone.
//
// A message is known by where it lies (an address that stays the same as long as someone holds it).
//
// Thread safety: each class says.
#pragma once

#include <memory>

namespace catan_ros {

// A loop of the framework's own thread, each round of which may be a run. All calls by that thread.
class LoopHook {
 public:
  virtual ~LoopHook() = default;
  // Until the loop is to go round; false: it is over.
  virtual bool wait() = 0;
  // Around what it does then; or that there is nothing to do.
  virtual void begin() = 0;
  virtual void end() = 0;
  virtual void skip() = 0;
};

// A topic: what is put on it, and what is read from it at any time. All calls from any thread.
class TopicHook {
 public:
  virtual ~TopicHook() = default;
  // The calling thread is about to give a message to the framework, and has done so. `message` may be null then, where
  // it has left this program.
  virtual void publishing(const void* message) = 0;
  virtual void published(const std::shared_ptr<const void>& message) = 0;
  // The calling thread has read a message.
  virtual void taken(const void* message) = 0;
};

// A callback that is a node. Called by any thread.
class CallbackHook {
 public:
  virtual ~CallbackHook() = default;
  // The framework would call it now, with that message.
  virtual void arrived(const std::shared_ptr<const void>& message) = 0;
};

}  // namespace catan_ros
