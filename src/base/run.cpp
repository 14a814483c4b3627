// What a run is charged, and the age of its inputs (include/catan/run.h).
#include "catan/run.h"

#include <algorithm>

#include "catan/channel.h"

namespace ctn {

void Run::charge(std::chrono::nanoseconds cpu) {
  if (cpu < std::chrono::nanoseconds{0}) {
    if (refused_charge_ == std::chrono::nanoseconds{0}) refused_charge_ = cpu;
    return;
  }
  const std::chrono::nanoseconds before = charged_.value_or(std::chrono::nanoseconds{0});
  charged_ = before + std::min(cpu, std::chrono::nanoseconds::max() - before);
}

// Origins that other processes tell may be anything from 0 up.
std::chrono::nanoseconds Run::age_of(const Input& input) const {
  if (input.origin == kNoOrigin) return kNoInput;
  return begin_ > input.origin ? begin_ - input.origin : std::chrono::nanoseconds{0};
}

std::chrono::nanoseconds Run::age_at(std::size_t slot) {
  ChannelBase* const channel = (*edges_)[slot].channel;
  if (channel == nullptr) return age_of(inputs_[slot]);
  return age_of(Input{0, 0, channel->take_origin(*this)});
}

std::chrono::nanoseconds Run::age(std::string_view input) {
  for (std::size_t slot = 0; edges_ != nullptr && slot < inputs_.size(); ++slot) {
    if ((*edges_)[slot].from == input) return age_at(slot);
  }
  return kNoInput;
}

bool Run::stale() {
  for (std::size_t slot = 0; edges_ != nullptr && slot < inputs_.size(); ++slot) {
    const std::chrono::nanoseconds limit = (*edges_)[slot].max_age;
    if (limit == kNoInput) continue;
    const std::chrono::nanoseconds age = age_at(slot);
    if (age != kNoInput && age > limit) return true;
  }
  return false;
}

}  // namespace ctn
