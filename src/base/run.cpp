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

std::chrono::nanoseconds Run::age_at(std::size_t input_index) {
  ChannelBase* const channel = (*edges_)[input_index].channel;
  if (channel == nullptr) return age_of(inputs_[input_index]);
  return age_of(Input{0, 0, channel->take_origin(*this)});
}

std::chrono::nanoseconds Run::age(std::string_view input) {
  for (std::size_t input_index = 0; edges_ != nullptr && input_index < inputs_.size(); ++input_index) {
    if ((*edges_)[input_index].from == input) return age_at(input_index);
  }
  return kNoInput;
}

bool Run::stale() {
  for (std::size_t input_index = 0; edges_ != nullptr && input_index < inputs_.size(); ++input_index) {
    const std::chrono::nanoseconds limit = (*edges_)[input_index].max_age;
    if (limit == kNoInput) continue;
    const std::chrono::nanoseconds age = age_at(input_index);
    if (age != kNoInput && age > limit) return true;
  }
  return false;
}

}  // namespace ctn
