#include "os/linux/poller.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <utility>

#include "os/linux/errno_text.h"

namespace ctn::os {
namespace {

constexpr int kMaxAtOnce = 64;
constexpr Poller::Key kTimerKey = Poller::kKeys;
constexpr Poller::Key kEventKey = Poller::kKeys + 1;

// As the call takes it on every machine; a timespec is smaller on some of 32 bits.
struct KernelTime {
  std::int64_t seconds;
  std::int64_t nanoseconds;
};

Error cannot_wait(int error) {
  return Error::environment("cannot wait for another descriptor: " + errno_text(error),
                            "raise the limit of open files (`ulimit -n`) or of fs.epoll.max_user_watches");
}

}  // namespace

Poller::Poller(Descriptor set, Descriptor timer, Descriptor event, bool call_takes_deadline)
    : set_(std::move(set)),
      timer_(std::move(timer)),
      event_(std::move(event)),
      call_takes_deadline_(call_takes_deadline) {
  ready_.reserve(kMaxAtOnce);
}

Result<std::unique_ptr<Poller>> Poller::make(bool call_takes_deadline) {
  Descriptor set(::epoll_create1(EPOLL_CLOEXEC));
  if (!set.valid()) return cannot_wait(errno);
  Descriptor timer(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!timer.valid()) return cannot_wait(errno);
  Descriptor event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!event.valid()) return cannot_wait(errno);
  std::unique_ptr<Poller> poller(new Poller(std::move(set), std::move(timer), std::move(event), call_takes_deadline));
  if (Status added = poller->add(poller->timer_, kTimerKey); !added.ok()) return added.error();
  if (Status added = poller->add(poller->event_, kEventKey); !added.ok()) return added.error();
  return poller;
}

Status Poller::add(const Descriptor& descriptor, Key key) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = key;
  if (::epoll_ctl(set_.number(), EPOLL_CTL_ADD, descriptor.number(), &event) != 0) return cannot_wait(errno);
  return Done{};
}

void Poller::remove(const Descriptor& descriptor) {
  ::epoll_ctl(set_.number(), EPOLL_CTL_DEL, descriptor.number(), nullptr);
}

// Also takes back that an earlier deadline has passed.
void Poller::set_timer(TimePoint deadline) {
  itimerspec when{};  // all zero: never
  if (deadline != kNever) {
    const Nanos since_boot = std::max(deadline.time_since_epoch(), Nanos{1});
    when.it_value.tv_sec = static_cast<time_t>(since_boot.count() / 1'000'000'000);
    when.it_value.tv_nsec = static_cast<long>(since_boot.count() % 1'000'000'000);
  }
  ::timerfd_settime(timer_.number(), TFD_TIMER_ABSTIME, &when, nullptr);
}

// As epoll_wait(). With a deadline of its own the call takes half of the system calls, and of their time: a program's
// link to its server does little else.
int Poller::wait_for_events(std::span<epoll_event> events, TimePoint deadline) {
  const int room = static_cast<int>(events.size());
#ifdef SYS_epoll_pwait2
  if (call_takes_deadline_ && deadline != kNever) {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    const Nanos since_boot = std::chrono::seconds{now.tv_sec} + Nanos{now.tv_nsec};
    const Nanos left = std::max(deadline.time_since_epoch(), since_boot) - since_boot;
    const KernelTime timeout{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
    const long count = ::syscall(SYS_epoll_pwait2, set_.number(), events.data(), room, &timeout, nullptr, 0);
    if (count >= 0 || errno == EINTR) return static_cast<int>(count);
    call_takes_deadline_ = false;
  }
#else
  call_takes_deadline_ = false;
#endif
  if (!call_takes_deadline_) set_timer(deadline);
  return ::epoll_wait(set_.number(), events.data(), room, -1);
}

const std::vector<Poller::Key>& Poller::wait(TimePoint deadline) {
  ready_.clear();
  std::array<epoll_event, kMaxAtOnce> events{};
  int count = -1;
  do {
    count = wait_for_events(events, deadline);
  } while (count < 0 && errno == EINTR);
  for (int i = 0; i < count; ++i) {
    const Key key = events.at(static_cast<std::size_t>(i)).data.u64;
    if (key < kKeys) ready_.push_back(key);
    if (key == kEventKey) {
      std::uint64_t wakes = 0;
      static_cast<void>(::read(event_.number(), &wakes, sizeof wakes) < 0);
    }
  }
  return ready_;
}

void Poller::wake() {
  const std::uint64_t one = 1;
  // It fails only when the counter is at its limit, and then the wake-up is under way already.
  static_cast<void>(::write(event_.number(), &one, sizeof one) < 0);
}

}  // namespace ctn::os
