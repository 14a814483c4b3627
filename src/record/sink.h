// Where what happens in a run goes: the writer of a record (writer.h), the memory of the last seconds (flight/).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/time.h"
#include "record/events.h"

namespace ctn::record {

// What a run has come to so far.
struct Totals {
  std::uint64_t plans_made = 0;  // in force or not, without the first
  Nanos planning_cpu{0};         // that making them took
  std::uint64_t starved = 0;     // how often a core was kept from its controller
  Nanos starved_for{0};          // all cores
  friend bool operator==(const Totals&, const Totals&) = default;
};

class Sink {
 public:
  virtual ~Sink() = default;

  virtual void add(const Run& run) = 0;
  virtual void add(const Trigger& trigger) = 0;
  virtual void add(const SlotUse& slot) = 0;
  virtual void add(const Steal& steal) = 0;
  virtual void add(const Overrun& overrun) = 0;
  virtual void add(const PlanChange& change) = 0;
  virtual void add(const CostChange& change) = 0;
  virtual void add(const AppChange& change) = 0;
  virtual void add(const ClockReading& reading) = 0;
  virtual void add(const Notice& notice) = 0;
  // As of now; each replaces what was told before.
  virtual void set_totals(const Totals& totals) = 0;
};

// For a sink that cares for some of it: what it does not take is passed over. It says `using PartialSink::add;`.
class PartialSink : public Sink {
 public:
  void add(const Run& /*run*/) override {}
  void add(const Trigger& /*trigger*/) override {}
  void add(const SlotUse& /*slot*/) override {}
  void add(const Steal& /*steal*/) override {}
  void add(const Overrun& /*overrun*/) override {}
  void add(const PlanChange& /*change*/) override {}
  void add(const CostChange& /*change*/) override {}
  void add(const AppChange& /*change*/) override {}
  void add(const ClockReading& /*reading*/) override {}
  void add(const Notice& /*notice*/) override {}
  void set_totals(const Totals& /*totals*/) override {}
};

// Hands on all of it, to each sink in turn. A sink that is derived from it may change, add or leave out some.
class ForwardingSink : public Sink {
 public:
  // The sinks outlive it.
  explicit ForwardingSink(std::vector<Sink*> to) : to_(std::move(to)) {}

  void add(const Run& run) override { forward(run); }
  void add(const Trigger& trigger) override { forward(trigger); }
  void add(const SlotUse& slot) override { forward(slot); }
  void add(const Steal& steal) override { forward(steal); }
  void add(const Overrun& overrun) override { forward(overrun); }
  void add(const PlanChange& change) override { forward(change); }
  void add(const CostChange& change) override { forward(change); }
  void add(const AppChange& change) override { forward(change); }
  void add(const ClockReading& reading) override { forward(reading); }
  void add(const Notice& notice) override { forward(notice); }
  void set_totals(const Totals& totals) override {
    for (Sink* const sink : to_) sink->set_totals(totals);
  }

 protected:
  template <class Event>
  void forward(const Event& event) {
    for (Sink* const sink : to_) sink->add(event);
  }

 private:
  std::vector<Sink*> to_;
};

}  // namespace ctn::record
