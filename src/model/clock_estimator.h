// What a clock that is not ours does, from the ticks that it is told of, or runs that a timer of its own begins:
// period and phase.
//
// Ticks may be told late, now and then by much, and some not at all; the clock drifts. How: each tick gets a number, by
// how many periods it is after those before. Through the last kWindow of them a line is drawn by least squares, twice
// again without those that are far from it. Its slope is the period; its height depends on what the ticks are for
// (TicksAre). A tick that is far from where it should be is passed over; kAstray of them in a row mean that the clock
// does something else now, and begin anew.
//
// Units: Nanos. Thread safety: none; one owner. The same ticks give the same answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "base/ticks.h"

namespace ctn::model {

enum class TicksAre {
  // The display's: what is done by then counts. As many lie above the line as below.
  kDeadlines,
  // A sensor's: with each there is something to read. Who reads before the tick is told gets what is a period older, so
  // the line lies where that and the wait for it cost least: at the height h above the middle that has the least
  // h + (part of the ticks above it) x (period), as in the newsvendor's problem (K. Arrow, T. Harris and J. Marschak,
  // "Optimal Inventory Policy", Econometrica 1951).
  kArrivals,
};

class ClockEstimator {
 public:
  static constexpr std::size_t kWindow = 240;
  static constexpr std::size_t kMinTicks = 16;  // ticks, before anything is said
  static constexpr int kAstray = 12;

  // `nominal`: about how often it ticks.
  explicit ClockEstimator(Nanos nominal, TicksAre what = TicksAre::kDeadlines) : nominal_(nominal), what_(what) {}

  // It ticked. One that is not after the newest is passed over.
  void add(TimePoint tick);

  // A tick of not long ago, and the period; none while too little is known, and where it ticks at another rate than it
  // should: by more than kFarOff; nor where it does not tick regularly: every other tick is off by more than kIrregular
  // of a period.
  static constexpr double kFarOff = 0.02;
  static constexpr double kIrregular = 0.1;
  std::optional<Ticks> ticks() const;

 private:
  struct Tick {
    std::int64_t number = 0;
    TimePoint at{};
  };
  struct Line {
    Tick through;
    double period = 0.0;  // ns
  };

  double period() const { return line_ ? line_->period : static_cast<double>(nominal_.count()); }
  void begin_anew(TimePoint tick);
  void fit();

  Nanos nominal_;
  TicksAre what_;
  std::deque<Tick> told_;
  std::optional<Line> line_;  // none: too few
  bool regular_ = false;
  int since_fit_ = 0;  // ticks
  int astray_ = 0;     // in a row
};

}  // namespace ctn::model
