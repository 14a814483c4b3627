// Random programs on shared CPUs: what must hold at every instant, whatever they do.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "os/fake/fake_os.h"

namespace ctn::os {
namespace {

constexpr int kCpus = 3;
constexpr int kThreads = 5;
constexpr TimePoint kStart{Nanos{1}};  // the threads have been made

enum class Op { kBurn, kBurnLong, kSleep, kWait, kWake, kSetLevel, kSetAffinity, kSetOnline };

struct Step {
  Op op{};
  int amount = 0;
  int target = 0;
};

// By thread; main, the first, is left alone.
using Program = std::vector<std::vector<Step>>;

struct Setting {
  Level level{};
  CpuSet cpus;
  friend bool operator==(const Setting&, const Setting&) = default;
};
using Settings = std::map<ThreadId, Setting>;

// A thread called burn() or was due to wake, until it went on: it wanted a CPU all the time.
struct Want {
  ThreadId thread;
  TimePoint begin;
  TimePoint end;
  friend bool operator==(const Want&, const Want&) = default;
};

struct Story {
  std::vector<FakeCpus::Stretch> stretches;
  std::vector<Want> wants;
  std::map<TimePoint, Settings> settings;  // from then on
  std::map<ThreadId, Nanos> asked;         // of CPU time
  std::map<ThreadId, Nanos> had;
  TimePoint end;
  friend bool operator==(const Story&, const Story&) = default;
};

class Stage {
 public:
  Story play(const Program& program) {
    os_.share_cpus(true);
    EXPECT_TRUE(os_.set_level(ThreadId{1}, Level::kDispatcher).ok());
    std::vector<std::unique_ptr<Thread>> threads;
    for (const std::vector<Step>& steps : program) {
      threads.push_back(os_.spawn("", [this, &steps] { act(steps); }));
    }
    threads.clear();
    story_.stretches = os_.stretches();
    story_.end = os_.now();
    return std::move(story_);
  }

 private:
  void act(const std::vector<Step>& steps) {
    const ThreadId self = os_.current_thread();
    os_.sleep_until(kStart);
    note_settings();
    for (const Step& step : steps) act(self, step);
    story_.had[self] = os_.thread_cpu_time();
  }

  void act(ThreadId self, const Step& step) {
    const ThreadId target{2 + step.target % kThreads};
    const TimePoint begin = os_.now();
    switch (step.op) {
      case Op::kBurn:
        return burn(self, Nanos{step.amount});
      case Op::kBurnLong:
        return burn(self, step.amount * FakeCpus::kSlice / 20);
      case Op::kSleep:
        os_.sleep_until(begin + Nanos{step.amount});
        return want(self, begin + Nanos{step.amount});
      case Op::kWait:
        if (os_.wait(word_, word_.load(), begin + Nanos{step.amount}) == WaitResult::kTimedOut) {
          want(self, begin + Nanos{step.amount});
        }
        return;
      case Op::kWake:
        ++word_;
        return os_.wake(word_);
      case Op::kSetLevel:
        os_.shift_level(target, static_cast<Level>(step.amount % 4));
        return note_settings();
      case Op::kSetAffinity:
        static_cast<void>(os_.set_affinity(target, some_cpus(step.amount)));
        return note_settings();
      case Op::kSetOnline:
        os_.set_cpu_online(1 + step.target % (kCpus - 1), step.amount % 2 == 0);
        return note_settings();
    }
  }

  void burn(ThreadId self, Nanos amount) {
    const TimePoint begin = os_.now();
    story_.asked[self] += amount;
    os_.burn(amount);
    want(self, begin);
  }

  void want(ThreadId self, TimePoint begin) { story_.wants.push_back({self, begin, os_.now()}); }

  static CpuSet some_cpus(int bits) {
    std::vector<int> cpus;
    for (int cpu = 0; cpu < kCpus; ++cpu) {
      if ((bits >> cpu & 1) != 0) cpus.push_back(cpu);
    }
    return cpus.empty() ? CpuSet{0} : CpuSet(cpus);
  }

  void note_settings() {
    Settings& now = story_.settings[os_.now()];
    now.clear();
    for (const ThreadId thread : os_.threads(os_.current_process()).value()) {
      now[thread] = {os_.level(thread).value(), os_.affinity(thread).value()};
    }
  }

  FakeOs os_{fake_topology(kCpus)};
  std::atomic<std::uint32_t> word_{0};
  Story story_;
};

rc::Gen<Step> any_step() {
  const auto op = rc::gen::weightedElement<Op>({{6, Op::kBurn},
                                                {2, Op::kBurnLong},
                                                {3, Op::kSleep},
                                                {2, Op::kWait},
                                                {2, Op::kWake},
                                                {4, Op::kSetLevel},
                                                {3, Op::kSetAffinity},
                                                {1, Op::kSetOnline}});
  return rc::gen::build<Step>(rc::gen::set(&Step::op, op), rc::gen::set(&Step::amount, rc::gen::inRange(0, 60)),
                              rc::gen::set(&Step::target, rc::gen::inRange(0, 60)));
}

Program any_program() {
  return *rc::gen::container<Program>(kThreads, rc::gen::container<std::vector<Step>>(any_step()));
}

// Instants between which nothing changes, but for which threads want a CPU and which have one.
std::set<TimePoint> instants(const Story& story) {
  std::set<TimePoint> times;
  for (const FakeCpus::Stretch& stretch : story.stretches) times.insert({stretch.begin, stretch.end});
  for (const Want& want : story.wants) times.insert({want.begin, want.end});
  for (const auto& [time, settings] : story.settings) times.insert(time);
  return times;
}

// Which thread has which CPU from then on. Nobody has two, and no CPU serves two.
std::map<int, ThreadId> holders(const Story& story, TimePoint time, const Settings& settings) {
  std::map<int, ThreadId> found;
  std::set<ThreadId> threads;
  for (const FakeCpus::Stretch& stretch : story.stretches) {
    if (stretch.begin > time || stretch.end <= time) continue;
    RC_ASSERT(found.emplace(stretch.cpu, stretch.thread).second);
    RC_ASSERT(threads.insert(stretch.thread).second);
    RC_ASSERT(settings.at(stretch.thread).level == stretch.level);
    RC_ASSERT(settings.at(stretch.thread).cpus.contains(stretch.cpu));
  }
  return found;
}

bool has_a_cpu(const std::map<int, ThreadId>& holders, ThreadId thread) {
  return std::any_of(holders.begin(), holders.end(), [&](const auto& holder) { return holder.second == thread; });
}

// A thread that wants a CPU and has none waits for CPUs that serve levels no lower than its own, all of them.
void check_instant(const Story& story, TimePoint time) {
  const Settings& settings = std::prev(story.settings.upper_bound(time))->second;
  const std::map<int, ThreadId> has = holders(story, time, settings);
  for (const Want& want : story.wants) {
    if (want.begin > time || want.end <= time || has_a_cpu(has, want.thread)) continue;
    for (const int cpu : settings.at(want.thread).cpus.cpus()) {
      RC_ASSERT(has.contains(cpu));
      RC_ASSERT(settings.at(has.at(cpu)).level >= settings.at(want.thread).level);
    }
  }
}

RC_GTEST_PROP(SharedCpusOfRandomPrograms, ServeTheHighestLevelsAtEveryInstant, ()) {
  const Program program = any_program();
  const Story story = Stage().play(program);
  for (const TimePoint time : instants(story)) {
    if (time >= kStart) check_instant(story, time);
  }
}

RC_GTEST_PROP(SharedCpusOfRandomPrograms, GiveEveryThreadWhatItAskedAndNoMoreThanThereIs, ()) {
  const Program program = any_program();
  Story story = Stage().play(program);
  std::map<ThreadId, Nanos> served;
  Nanos sum{0};
  for (const FakeCpus::Stretch& stretch : story.stretches) {
    RC_ASSERT(stretch.begin < stretch.end);
    served[stretch.thread] += stretch.end - stretch.begin;
    sum += stretch.end - stretch.begin;
  }
  for (const auto& [thread, had] : story.had) {
    RC_ASSERT(had == story.asked[thread]);
    RC_ASSERT(had == served[thread]);
  }
  RC_ASSERT(sum <= kCpus * (story.end - TimePoint{}));
}

RC_GTEST_PROP(SharedCpusOfRandomPrograms, AreDeterministic, ()) {
  const Program program = any_program();
  RC_ASSERT(Stage().play(program) == Stage().play(program));
}

}  // namespace
}  // namespace ctn::os
