// What a user should hear of. Anybody may say it, at any time and under any lock, because here it is only put down:
// kept for the snapshot and the record, and queued for the user's callback, which deliver() calls with no lock held.
//
// Thread safety: add() and newest() from any thread; deliver() and take_unrecorded() from one at a time: the
// housekeeping thread while it runs, before and after whoever starts and stops the session.
#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "os/os.h"
#include "record/events.h"

namespace ctn::runtime {

class Notices {
 public:
  using Callback = std::function<void(const std::string&)>;

  // `on_notice` may be empty. `recorded`: somebody takes them for the record.
  Notices(os::Os& os, Callback on_notice, bool recorded)
      : os_(os), on_notice_(std::move(on_notice)), recorded_(recorded) {}

  void add(const std::string& kind, const std::string& detail) { add({os_.now(), kind, detail}); }
  void add(record::Notice notice);

  // The newest, oldest first, as a user reads them.
  std::vector<std::string> newest() const;

  // Tells the callback all that it was not told yet, in order. What the callback itself adds is told, too.
  void deliver();
  std::vector<record::Notice> take_unrecorded();

 private:
  os::Os& os_;
  const Callback on_notice_;
  const bool recorded_;
  mutable std::mutex mutex_;  // held for as long as it takes to put something down; guards what follows
  std::deque<std::string> newest_;
  std::deque<std::string> undelivered_;
  std::vector<record::Notice> unrecorded_;
};

}  // namespace ctn::runtime
