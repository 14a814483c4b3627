// Any text as a quantity: what is taken is in range, and printing it and reading it back gives the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "config/quantity.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ctn::config;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto duration = parse_duration(text); duration.ok()) {
    require(*duration >= ctn::Nanos::zero() && *duration <= std::chrono::hours{240});
    const auto again = parse_duration(format_duration(*duration));
    require(again.ok() && *again == *duration);
  }
  if (const auto rate = parse_rate(text); rate.ok()) {
    require(rate->hertz() >= 1e-5 && rate->hertz() <= 1e6);
    const auto again = parse_rate(format_rate(*rate));
    require(again.ok() && *again == *rate);
  }
  if (const auto fraction = parse_percentage(text); fraction.ok()) {
    require(*fraction >= 0.0 && *fraction < 1.0);
    const auto again = parse_percentage(format_percentage(*fraction));
    require(again.ok() && *again == *fraction);
  }
  if (const auto growth = parse_growth(text); growth.ok()) require(*growth >= 0.0 && *growth <= 10.0);
  return 0;
}
