// What a user should be told. Any thread may add a notice, at any time and under any lock, because add() only stores
// it: for snapshots and the record, and in the queue for the user's callback, which deliver() calls with no lock held.
//
// Thread safety: add() and newest() from any thread; deliver() and take_unrecorded() from one at a time: in life the
// housekeeping thread while it runs, before and after whoever starts and stops the session; in a program whose nodes a
// server schedules, the thread that watches the server.
#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "record/events.h"

namespace ctn::driver {

class Notices {
 public:
  using Callback = std::function<void(const std::string&)>;

  // `on_notice` may be empty. `recorded`: somebody takes them for the record.
  Notices(Callback on_notice, bool recorded) : on_notice_(std::move(on_notice)), recorded_(recorded) {}

  void add(record::Notice notice);

  // The newest, oldest first, as a user reads them.
  std::vector<std::string> newest() const;

  // Calls the callback with all notices that it has not had yet, in order, those included that the callback itself
  // adds.
  void deliver();
  std::vector<record::Notice> take_unrecorded();

 private:
  const Callback on_notice_;
  const bool recorded_;
  mutable std::mutex mutex_;  // held only while a notice is stored or copied; guards what follows
  std::deque<std::string> newest_;
  std::deque<std::string> undelivered_;
  std::vector<record::Notice> unrecorded_;
};

}  // namespace ctn::driver
