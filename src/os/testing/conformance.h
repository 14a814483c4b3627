// For the conformance suite: how to make each implementation of Os, and how to consume CPU time on it.
#pragma once

#include "os/fake/fake_os.h"
#include "os/fake/faulty_os.h"
#include "os/linux/linux_os.h"
#include "os/os.h"

namespace ctn::os::conformance {

constexpr Nanos kTimeout = std::chrono::seconds(60);

class Platform {
 public:
  virtual ~Platform() = default;
  virtual Os& os() = 0;
  // Consumes at least that much CPU time on the calling thread.
  virtual void work(Nanos cpu_time) = 0;
  // The most that a call may take which has nothing to wait for. A real machine may be held up by others for any time;
  // what is longer than this is not that.
  virtual Nanos at_once() const { return kTimeout; }
};

class LinuxPlatform : public Platform {
 public:
  Os& os() override { return *os_; }
  void work(Nanos cpu_time) override {
    const Nanos end = os_->thread_cpu_time() + cpu_time;
    const TimePoint give_up = os_->now() + kTimeout;
    while (os_->thread_cpu_time() < end && os_->now() < give_up) continue;
  }

 private:
  std::unique_ptr<Os> os_ = make_linux_os();
};

class FakePlatform : public Platform {
 public:
  Os& os() override { return os_; }
  void work(Nanos cpu_time) override { os_.burn(cpu_time); }
  Nanos at_once() const override { return Nanos{0}; }

 protected:
  FakeOs& fake() { return os_; }

 private:
  FakeOs os_;
};

class FakeWithoutPermission : public FakePlatform {
 public:
  FakeWithoutPermission() {
    RealTimeFacts facts;
    facts.why_not = "this machine is made up, and strict";
    facts.reserved_by = "nothing";
    fake().set_real_time_facts(facts);
  }
};

template <class Inner>
class FaultyPlatform : public Platform {
 public:
  Os& os() override { return os_; }
  void work(Nanos cpu_time) override { inner_.work(cpu_time); }
  Nanos at_once() const override { return inner_.at_once(); }

 private:
  Inner inner_;
  FaultyOs os_{inner_.os()};
};

struct Port {
  const char* name;
  std::unique_ptr<Platform> (*make)();
  friend void PrintTo(const Port& port, std::ostream* out) { *out << port.name; }
};

template <class Kind>
std::unique_ptr<Platform> make_platform() {
  return std::make_unique<Kind>();
}

// A thread that waits until the end of the scope, for others to act upon.
class Parked {
 public:
  explicit Parked(Os& os) : os_(os) {
    thread_ = os.spawn("parked", [this] {
      id_ = static_cast<std::uint32_t>(os_.current_thread());
      os_.wake(id_);
      os_.wait(stop_, 0, os_.now() + kTimeout);
    });
    os.wait(id_, 0, os.now() + kTimeout);
  }
  ~Parked() { end(); }
  Parked(const Parked&) = delete;
  Parked& operator=(const Parked&) = delete;

  ThreadId id() const { return static_cast<ThreadId>(id_.load()); }

  void end() {
    stop_ = 1;
    os_.wake(stop_);
    thread_->join();
  }

 private:
  Os& os_;
  std::atomic<std::uint32_t> id_{0};
  std::atomic<std::uint32_t> stop_{0};
  std::unique_ptr<Thread> thread_;
};

}  // namespace ctn::os::conformance
