// What a shared core owes to ordinary threads: for every stretch of time that real-time levels had, slack / (1 - slack)
// of it. A share that is too small to be worth two switches is carried over as a debt until kSmallestSlack has come
// together. So over any row of whole frames ordinary threads have had their part of the time but for less than
// kSmallestSlack. More than their part in one frame is not deducted later.
//
// Where there is time to be waited for anyway, what is owed is paid from it, however little: carried over, it would
// make a later frame longer than planned. Thus, of frames that use no more than was planned, k are never longer than k
// T + kSmallestSlack.
//
// Units: Nanos. Thread safety: none; one owner.
#pragma once

#include "base/time.h"

namespace ctn::dispatch {

constexpr Nanos kSmallestSlack = std::chrono::microseconds{200};

class SlackAccount {
 public:
  // Precondition: 0 <= slack < 1. What is owed stays owed.
  void set_slack(double slack);

  // Real-time levels had `busy`: the debt grows by the slack that belongs to it.
  void charge(Nanos busy);
  // Ordinary threads were given so much. What is beyond the debt is not kept as a credit.
  void pay(Nanos given);

  // What is to be paid now: the whole debt, or nothing while it is less than kSmallestSlack.
  Nanos debt_due() const { return debt_ >= kSmallestSlack ? debt_ : Nanos{0}; }

  // Of a time that is to be waited anyway: the part that may go to real-time levels before ordinary threads get the
  // rest, so that nothing is owed at its end. None of less than kSmallestSlack, which is not worth dividing.
  Nanos busy_part(Nanos wait) const;

 private:
  Nanos slack_for(Nanos busy) const;

  double slack_ = 0.0;
  Nanos debt_{0};  // < kSmallestSlack between frames
};

}  // namespace ctn::dispatch
