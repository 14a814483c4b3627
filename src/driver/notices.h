// What a user should be told. Any thread may add a notice, at any time and under any lock, because add() only stores
// it: for snapshots and the record, and in the queue for the thread that delivers them to the user's callback
// (runtime/notice_thread.h), who is woken.
//
// Thread safety: add() and newest() from any thread; deliver() from one at a time, take_unrecorded() from one at a
// time.
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

  // `on_added` is called after each that is added, by the thread that adds it, and so must not block; empty: no thread
  // delivers them. `recorded`: they are taken for the record.
  Notices(std::function<void()> on_added, bool recorded) : on_added_(std::move(on_added)), recorded_(recorded) {}

  void add(record::Notice notice);

  // The newest, oldest first, as a user reads them.
  std::vector<std::string> newest() const;

  // Calls the callback, with no lock held, with all that have not been delivered yet, in order, those included that the
  // callback itself adds.
  void deliver(const Callback& on_notice);
  std::vector<record::Notice> take_unrecorded();

 private:
  const std::function<void()> on_added_;
  const bool recorded_;
  mutable std::mutex mutex_;  // held only while a notice is stored or copied; guards what follows
  std::deque<std::string> newest_;
  std::deque<std::string> undelivered_;
  std::vector<record::Notice> unrecorded_;
};

}  // namespace ctn::driver
