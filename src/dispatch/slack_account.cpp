#include "dispatch/slack_account.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ctn::dispatch {
namespace {

Nanos scaled(Nanos duration, double factor) {
  return Nanos{std::llround(static_cast<double>(duration.count()) * factor)};
}

}  // namespace

void SlackAccount::set_slack(double slack) {
  assert(slack >= 0.0 && slack < 1.0);
  slack_ = slack;
}

Nanos SlackAccount::slack_for(Nanos busy) const { return scaled(busy, slack_ / (1.0 - slack_)); }

void SlackAccount::charge(Nanos busy) { debt_ += slack_for(busy); }

void SlackAccount::pay(Nanos given) { debt_ = std::max(debt_ - given, Nanos{0}); }

Nanos SlackAccount::busy_part(Nanos wait) const {
  if (slack_ == 0.0) return wait;
  if (wait < kSmallestSlack) return Nanos{0};
  // The busy part b makes the debt grow to debt + b s / (1 - s), which the rest, wait - b, is to pay.
  return scaled(std::max(wait - debt_, Nanos{0}), 1.0 - slack_);
}

}  // namespace ctn::dispatch
