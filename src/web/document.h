// A document of the source (source.h), kept for a moment, so that the source is asked seldom, however many clients ask.
//
// Thread safety: all functions from any thread; they lock, and whoever asks while the source is being asked waits.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "base/result.h"
#include "base/time.h"
#include "os/clock.h"

namespace ctn::web {

class Document {
 public:
  using Text = std::shared_ptr<const Result<std::string>>;
  using Ask = std::function<Result<std::string>()>;

  Document(os::Clock& clock, Nanos kept_for, Ask ask) : clock_(clock), kept_for_(kept_for), ask_(std::move(ask)) {}

  Text get() {
    const std::lock_guard lock(mutex_);
    if (!text_ || clock_.now() >= stale_at_) {
      text_ = std::make_shared<const Result<std::string>>(ask_());
      stale_at_ = clock_.now() + kept_for_;
    }
    return text_;
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    text_.reset();
  }

 private:
  os::Clock& clock_;
  const Nanos kept_for_;
  const Ask ask_;
  std::mutex mutex_;
  TimePoint stale_at_{};
  Text text_;
};

}  // namespace ctn::web
