// A world in virtual time for tests of controllers: each gets an actuator of its own, runs take as long as the test
// says, each has a CPU of its own unless the test says otherwise, and what is done is remembered. It steps controllers
// when they asked for it, and when they are woken. A breach of what actuator.h allows to a controller is a failure of
// the test.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "driver/actuator.h"
#include "driver/core_driver.h"
#include "driver/subchain_pacer.h"
#include "record/events.h"

namespace ctn::driver {

constexpr Nanos kNeverEnds = Nanos::max();

class FakeWorld {
 public:
  // How long a run works; kNeverEnds: until end_hung_run(). 0: it is over before its trigger returns.
  using Cost = std::function<Nanos(SubchainId, std::uint64_t number)>;

  struct Subchain {
    std::optional<std::size_t> holder;
    std::optional<dispatch::RunState> handed_over = dispatch::RunState{};
    std::vector<os::Level> levels;  // by node
    os::CpuSet cpus;
    std::vector<record::Trigger> triggers;
    std::uint64_t completed = 0;
    bool awaited = false;
    bool newcomers = false;
    TimePoint busy_until{};  // kNever: its run hangs
    std::uint64_t level_changes = 0;
    std::uint64_t moves = 0;
    std::uint64_t outputs = 0;
    TimePoint newest_output{};
    std::vector<std::size_t> subscribers;  // controllers
    Nanos used{0};                         // CPU time of all runs before the one under way
    TimePoint working_since{};
    std::optional<Nanos> used_at_begin;  // of the run that is measured
    std::uint64_t measured = 0;          // how often its CPU time was asked for
  };
  struct Hang {
    SubchainId subchain;
    bool began = false;
    TimePoint at{};
    friend bool operator==(const Hang&, const Hang&) = default;
  };

  // A pacer a subchain, which has `nodes` nodes, and a driver a core.
  FakeWorld(std::size_t subchain_count, std::size_t cores, Cost cost, std::size_t nodes = 1)
      : subchains(subchain_count), cost_(std::move(cost)) {
    for (Subchain& subchain : subchains) subchain.levels.assign(nodes, os::Level::kOrdinary);
    for (std::size_t index = 0; index < subchain_count + cores; ++index) {
      Acting& acting = acting_.emplace_back(*this, index);
      if (index < subchain_count) {
        acting.controller = std::make_unique<SubchainPacer>(acting, SubchainId(index));
      } else {
        acting.controller =
            std::make_unique<CoreDriver>(acting, static_cast<int>(index - subchain_count), subchain_count);
      }
    }
  }
  FakeWorld(const FakeWorld&) = delete;
  FakeWorld& operator=(const FakeWorld&) = delete;

  // All are woken to look.
  void publish(policy::Assignment assignment) {
    assignment.number = ++published_;
    assignment_ = std::make_unique<policy::Assignment>(std::move(assignment));
    for (Acting& acting : acting_) acting.until = now;
  }

  // A thread joins each of its nodes.
  void join(SubchainId id) {
    Subchain& subchain = of(id);
    subchain.levels.assign(subchain.levels.size(), os::Level::kOrdinary);
    subchain.cpus = {};
    subchain.newcomers = true;
  }

  void end_hung_run(SubchainId id) { of(id).busy_until = now; }

  void run_until(TimePoint end) {
    while (true) {
      TimePoint next = end;
      for (const Ending& ending : endings_) next = std::min(next, ending_of(ending));
      for (const Acting& acting : acting_) next = std::min(next, acting.until);
      if (next >= end && now >= end) return;
      now = std::max(now, next);
      end_runs();
      for (Acting& acting : acting_) {
        if (acting.until <= now) step(acting);
      }
    }
  }
  void run_for(Nanos duration) { run_until(now + duration); }

  Subchain& of(SubchainId id) { return subchains[id.index()]; }
  // Of an unscheduled node, of which there is but one, only outputs and subscribers count.
  Subchain& of(const plan::Leader& leader) {
    const SubchainId* const subchain = std::get_if<SubchainId>(&leader);
    return subchain != nullptr ? of(*subchain) : unscheduled;
  }
  // When its triggers were sent, in milliseconds.
  std::vector<double> sent(SubchainId id) {
    std::vector<double> times;
    for (const record::Trigger& trigger : of(id).triggers) {
      times.push_back(to_millis(trigger.sent - TimePoint{}).count());
    }
    return times;
  }
  // Lets a test look at the world after each step.
  // CPU time that the threads of a subchain have used so far; a test may say otherwise.
  std::function<Nanos(SubchainId)> cpu_time = [this](SubchainId id) {
    const Subchain& subchain = of(id);
    const TimePoint until = std::min(now, subchain.busy_until);
    return subchain.used + std::max(until - subchain.working_since, Nanos{0});
  };
  // Whether a run gives output.
  std::function<bool(SubchainId, std::uint64_t number)> gives_output = [](SubchainId, std::uint64_t) { return true; };
  std::size_t max_subscribers = 4;
  // An output of an unscheduled node, or one that no run of ours has given, as a process may pretend.
  void give_output(const plan::Leader& id) {
    Subchain& leader = of(id);
    ++leader.outputs;
    leader.newest_output = now;
    for (const std::size_t subscriber : leader.subscribers) {
      if (leader.outputs >= acting_[subscriber].awaited_outputs) acting_[subscriber].until = now;
    }
  }
  // Lets a test look at the world after each step.
  std::function<void()> after_step = [] {};

  TimePoint now{};
  std::vector<Subchain> subchains;
  Subchain unscheduled;
  std::optional<Ticks> clock;  // of others, as far as it is known
  std::vector<dispatch::SlotUse> slots;
  std::vector<dispatch::Steal> steals;
  std::vector<Hang> hangs;
  std::vector<dispatch::Overrun> overruns;
  std::uint64_t steps = 0;

 private:
  struct Ending {
    SubchainId subchain;
    std::uint64_t number = 0;
    TimePoint at{};
  };

  class Acting final : public Actuator {
   public:
    Acting(FakeWorld& world, std::size_t number) : world_(&world), number_(number) {}

    const policy::Assignment& assignment() override { return *world_->assignment_; }
    std::optional<dispatch::RunState> take(SubchainId id) override {
      Subchain& subchain = world_->of(id);
      if (!subchain.handed_over) return std::nullopt;
      EXPECT_FALSE(subchain.holder) << "two hold one subchain";
      subchain.holder = number_;
      subchain.newcomers = false;
      return std::exchange(subchain.handed_over, std::nullopt);
    }
    void hand_over(SubchainId id, const dispatch::RunState& state) override {
      Subchain& subchain = held(id);
      for (const os::Level level : subchain.levels) EXPECT_EQ(level, os::Level::kOrdinary) << "handed over raised";
      EXPECT_EQ(state.sent, subchain.triggers.size()) << "a trigger is lost in a hand-over";
      for (const Subchain& leader : world_->subchains) {
        EXPECT_EQ(std::count(leader.subscribers.begin(), leader.subscribers.end(), number_), 0)
            << "is still subscribed";
      }
      subchain.awaited = false;
      subchain.holder.reset();
      subchain.handed_over = state;
      const std::size_t next = holder_of(id, world_->assignment_->places[id.index()], world_->subchains.size());
      world_->acting_[next].until = world_->now;
    }
    void move(SubchainId id, const os::CpuSet& cpus) override {
      held(id).cpus = cpus;
      ++held(id).moves;
    }
    void set_level(SubchainId id, os::Level level) override {
      held(id).levels.assign(held(id).levels.size(), level);
      ++held(id).level_changes;
    }
    void set_levels(SubchainId id, const policy::SubchainPlace& place) override {
      for (std::size_t node = 0; node < held(id).levels.size(); ++node) held(id).levels[node] = place.level_of(node);
      ++held(id).level_changes;
    }
    bool threads_joined() override {
      bool any = false;
      for (Subchain& subchain : world_->subchains) {
        if (subchain.holder == number_) any |= std::exchange(subchain.newcomers, false);
      }
      return any;
    }
    void trigger(SubchainId id, std::uint64_t number, TimePoint due) override {
      EXPECT_EQ(number, held(id).triggers.size() + 1) << "triggers are counted one by one";
      EXPECT_LE(due, world_->now);
      held(id).triggers.push_back({id, number, due, world_->now});
      world_->begin_run(id, number);
    }
    std::uint64_t completed(SubchainId id) const override { return world_->of(id).completed; }
    void await_completion(SubchainId id, bool wanted, std::uint64_t known) override {
      held(id).awaited = wanted;
      if (wanted && held(id).completed != known) completion_came = true;
    }
    void begin_run(SubchainId id) override { held(id).used_at_begin = world_->cpu_time(id); }
    Nanos cpu_time(SubchainId id) override {
      EXPECT_TRUE(held(id).used_at_begin) << "from when?";
      ++held(id).measured;
      return world_->cpu_time(id) - held(id).used_at_begin.value_or(Nanos{0});
    }
    Outputs outputs(const plan::Leader& id) const override {
      const Subchain& leader = world_->of(id);
      return {leader.outputs, leader.newest_output};
    }
    bool await_outputs(const plan::Leader& id, std::uint64_t count) override {
      ignore_outputs(id);
      Subchain& leader = world_->of(id);
      awaited_outputs = count;
      if (leader.outputs >= count) completion_came = true;
      if (leader.subscribers.size() >= world_->max_subscribers) return false;
      leader.subscribers.push_back(number_);
      return true;
    }
    void ignore_outputs(const plan::Leader& id) override { std::erase(world_->of(id).subscribers, number_); }
    std::optional<Ticks> clock(NodeId /*node*/) const override { return world_->clock; }
    void slot_over(const dispatch::SlotUse& slot) override { world_->slots.push_back(slot); }
    void stole(const dispatch::Steal& steal) override { world_->steals.push_back(steal); }
    void hang_changed(SubchainId id, bool began, TimePoint at) override { world_->hangs.push_back({id, began, at}); }
    void over_budget(const dispatch::Overrun& overrun) override {
      EXPECT_EQ(overrun.number, held(overrun.subchain).triggers.size());
      world_->overruns.push_back(overrun);
    }

    std::unique_ptr<Controller> controller;
    TimePoint until = kNever;      // when it steps next
    bool completion_came = false;  // while it was deciding
    std::uint64_t awaited_outputs = 0;

   private:
    Subchain& held(SubchainId id) {
      EXPECT_EQ(world_->of(id).holder, number_) << "not held by the controller that acts";
      return world_->of(id);
    }

    FakeWorld* world_;
    std::size_t number_;
  };

  void step(Acting& acting) {
    acting.until = kNever;
    acting.completion_came = false;
    const TimePoint asked_for = acting.controller->step(now);
    acting.until = std::min(acting.until, acting.completion_came ? now : asked_for);
    ++steps;
    after_step();
  }

  // One after the other, as on a thread.
  void begin_run(SubchainId id, std::uint64_t number) {
    const Nanos cost = cost_(id, number);
    if (cost == Nanos{0}) {
      of(id).completed = number;
      if (gives_output(id, number)) give_output(id);
      return;
    }
    of(id).used = cpu_time(id);
    of(id).working_since = now;
    of(id).busy_until = cost == kNeverEnds ? kNever : std::max(of(id).busy_until, now) + cost;
    endings_.push_back({id, number, of(id).busy_until});
  }
  TimePoint ending_of(const Ending& ending) const {
    return ending.at == kNever ? subchains[ending.subchain.index()].busy_until : ending.at;
  }
  void end_runs() {
    std::erase_if(endings_, [&](const Ending& ending) {
      if (ending_of(ending) > now) return false;
      Subchain& subchain = of(ending.subchain);
      subchain.completed = std::max(subchain.completed, ending.number);
      if (gives_output(ending.subchain, ending.number)) give_output(ending.subchain);
      if (subchain.awaited) acting_[*subchain.holder].until = now;
      return true;
    });
  }

  Cost cost_;
  std::deque<Acting> acting_;
  std::unique_ptr<policy::Assignment> assignment_;
  std::uint64_t published_ = 0;
  std::vector<Ending> endings_;
};

}  // namespace ctn::driver
