#include "run/display.h"

namespace ctn::vr::run {

void Display::finished(const Picture& picture) {
  advance(picture.finished - std::chrono::nanoseconds(1));
  newest_ = picture;
  fresh_ = true;
}

void Display::advance(std::chrono::nanoseconds until) {
  for (; next_ <= until; next_ += clock_.period) {
    if (newest_) photons_.push_back({next_, *newest_, fresh_});
    fresh_ = false;
  }
}

}  // namespace ctn::vr::run
