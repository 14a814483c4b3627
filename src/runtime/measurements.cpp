#include "runtime/measurements.h"

namespace ctn::runtime {

void SampleWindow::add(Nanos sample) {
  ++count_;
  if (samples_.size() < kSamples) {
    samples_.push_back(to_millis(sample).count());
  } else {
    samples_[next_] = to_millis(sample).count();
    next_ = (next_ + 1) % kSamples;
  }
}

Summary SampleWindow::summary_ms() const {
  Summary summary = summarize(samples_);
  summary.count = count_;
  return summary;
}

}  // namespace ctn::runtime
