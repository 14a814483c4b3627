// Runs that a test plays: it says when there is a trigger, and is told what became of it.
//
// Thread safety: trigger() and finish() from any thread; text() once the node's thread has ended, or between runs.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>

#include "common/node_runs.h"

namespace catan_ros {

// What a test and the runs of its node share.
class Play {
 public:
  void trigger(int count = 1) {
    const std::lock_guard lock(mutex_);
    triggers_ += count;
    changed_.notify_all();
  }
  // No triggers any more, once those that were given are used up.
  void finish() {
    const std::lock_guard lock(mutex_);
    finished_ = true;
    changed_.notify_all();
  }
  // The server has let go of the subchain; the second returns when the node waits until it is complete.
  void is_incomplete() {
    const std::lock_guard lock(mutex_);
    incomplete_ = true;
    changed_.notify_all();
  }
  void let_go() {
    is_incomplete();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return is_let_go_; });
  }
  void complete() {
    const std::lock_guard lock(mutex_);
    incomplete_ = false;
    changed_.notify_all();
  }
  // Until so many runs have ended.
  void wait_for_ends(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return ends_ >= count; });
  }
  // "1 took camera:3 with output; 2 without; "
  std::string text() const {
    const std::lock_guard lock(mutex_);
    return text_;
  }

 private:
  friend class PlayedRuns;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int triggers_ = 0;
  int ends_ = 0;
  bool finished_ = false;
  bool incomplete_ = false;
  bool is_let_go_ = false;
  std::string text_;
};

class PlayedRuns final : public Runs {
 public:
  // `waits` is false for a node that keeps its own time.
  explicit PlayedRuns(Play& play, bool waits = true) : play_(play), waits_(waits) {}

  ctn::Awaited await() override {
    std::unique_lock lock(play_.mutex_);
    if (!waits_) return play_.finished_ ? ctn::Awaited::kStopped : ctn::Awaited::kTrigger;
    play_.changed_.wait(lock, [&] { return play_.triggers_ > 0 || play_.incomplete_ || play_.finished_; });
    if (play_.incomplete_ && !play_.finished_) return ctn::Awaited::kIncomplete;
    return play_.triggers_ > 0 && play_.triggers_-- > 0 ? ctn::Awaited::kTrigger : ctn::Awaited::kStopped;
  }
  bool await_complete() override {
    std::unique_lock lock(play_.mutex_);
    play_.is_let_go_ = true;
    play_.changed_.notify_all();
    play_.changed_.wait(lock, [&] { return !play_.incomplete_ || play_.finished_; });
    play_.is_let_go_ = false;
    return !play_.incomplete_;
  }
  void begin() override {
    ++number_;
    taken_.clear();
  }
  void end(bool output) override {
    const std::lock_guard lock(play_.mutex_);
    play_.text_ += std::to_string(number_) + taken_ + (output ? " with output; " : " without; ");
    ++play_.ends_;
    play_.changed_.notify_all();
  }
  std::uint64_t number() const override { return number_; }
  void take(const std::string& from, std::uint64_t run) override {
    taken_ += " took " + from + ":" + std::to_string(run);
  }
  void keep(const std::string& from, std::uint64_t run) override {
    taken_ += " had " + from + ":" + std::to_string(run);
  }

 private:
  Play& play_;
  const bool waits_;
  std::uint64_t number_ = 0;
  std::string taken_;
};

}  // namespace catan_ros
