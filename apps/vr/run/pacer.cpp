#include "run/pacer.h"

#include <algorithm>

namespace ctn::vr::run {
namespace {

using std::chrono::nanoseconds;

constexpr int kStart = 2;     // the first lead: a period divided by this
constexpr int kBackOff = 10;  // what a miss adds: likewise
constexpr int kCreep = 500;   // what time to spare takes away: likewise
constexpr int kComfort = 16;  // more than this is time to spare: likewise

}  // namespace

Pacer::Pacer(const Clock& display, nanoseconds look)
    : display_(display), look_(look), lead_(display.period / kStart), tick_(nanoseconds::min()) {}

bool Pacer::due(nanoseconds now) {
  const nanoseconds next = display_.next(now);
  // At the last look before it would be too late.
  if (next == tick_ || now + look_ <= next - lead_) return false;
  tick_ = next;
  return true;
}

void Pacer::done(nanoseconds spare) {
  if (spare < nanoseconds(0)) {
    lead_ += display_.period / kBackOff;
  } else if (spare > display_.period / kComfort) {
    lead_ -= display_.period / kCreep;
  }
  lead_ = std::clamp(lead_, nanoseconds(0), display_.period - look_);
}

}  // namespace ctn::vr::run
