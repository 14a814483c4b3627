#include "os/linux/log_output.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "os/linux/signals_blocked.h"

namespace ctn::os {
namespace {

// Waits for the file. What it does not take at all (a disk that is full, a pipe whose reader is gone) is dropped.
void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(file, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {  // whoever shares the file may have set O_NONBLOCK
      pollfd ready{.fd = file, .events = POLLOUT, .revents = 0};
      ::poll(&ready, 1, -1);
    } else if (count == 0 || errno != EINTR) {
      return;
    }
  }
}

}  // namespace

class LogOutput::Writer {
 public:
  Writer(int file, TellLost tell_lost) : file_(file), tell_lost_(std::move(tell_lost)) {}

  static void add(const std::shared_ptr<Writer>& self, std::string text);
  bool finish(Nanos at_most);
  void end();

 private:
  static bool start(const std::shared_ptr<Writer>& self);
  void run();
  // Precondition: mutex_ is locked.
  void put_in_place_of_lost() {
    if (lost_ > 0) texts_.push_back(tell_lost_(std::exchange(lost_, 0)));
  }

  const int file_;
  const TellLost tell_lost_;
  std::mutex mutex_;  // guards what follows; never held while the file is written
  std::condition_variable changed_;
  std::deque<std::string> texts_;
  std::uint64_t lost_ = 0;
  bool writing_ = false;  // what it has taken from `texts_`
  bool started_ = false;
  bool ending_ = false;
};

// Signals are for threads that expect them.
bool LogOutput::Writer::start(const std::shared_ptr<Writer>& self) {
  const SignalsBlocked in_the_new_thread;
  try {
    std::thread([self] { self->run(); }).detach();
  } catch (const std::system_error&) {
    return false;
  }
  return true;
}

void LogOutput::Writer::add(const std::shared_ptr<Writer>& self, std::string text) {
  std::unique_lock lock(self->mutex_);
  if (!self->started_) self->started_ = start(self);
  if (!self->started_) {
    lock.unlock();
    return write_all(self->file_, text);
  }
  if (self->texts_.size() >= kKept) {
    ++self->lost_;
    return;
  }
  self->put_in_place_of_lost();
  self->texts_.push_back(std::move(text));
  self->changed_.notify_all();
}

void LogOutput::Writer::run() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (texts_.empty()) put_in_place_of_lost();
    if (texts_.empty()) {
      changed_.wait(lock);
      continue;
    }
    const std::string text = std::move(texts_.front());
    texts_.pop_front();
    writing_ = true;
    lock.unlock();
    write_all(file_, text);
    lock.lock();
    writing_ = false;
    changed_.notify_all();
  }
}

bool LogOutput::Writer::finish(Nanos at_most) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, at_most, [this] { return texts_.empty() && lost_ == 0 && !writing_; });
}

void LogOutput::Writer::end() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  changed_.notify_all();
}

LogOutput::LogOutput(int file, TellLost tell_lost) : writer_(std::make_shared<Writer>(file, std::move(tell_lost))) {}

LogOutput::~LogOutput() { writer_->end(); }

void LogOutput::write(std::string text) { Writer::add(writer_, std::move(text)); }

bool LogOutput::finish(Nanos at_most) { return writer_->finish(at_most); }

}  // namespace ctn::os
