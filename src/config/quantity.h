// Quantities with units, as the app file, the cost file and the command line write them.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "base/time.h"

namespace ctn::config {

// "8.33ms", "20us", "1.5 s", "100ns". Zero is a duration; a negative one is none. At most 10 days.
Result<Nanos> parse_duration(std::string_view text);
// "50Hz", "1.5kHz". Positive, 1e-5 Hz to 1e6 Hz.
Result<Rate> parse_rate(std::string_view text);
// "6%" -> 0.06. In [0, 1).
Result<double> parse_percentage(std::string_view text);
// "0.5%/s" -> 0.005 a second. At most 1000%/s.
Result<double> parse_growth(std::string_view text);

// The inverse: parsing what they print gives the same value. The largest unit in which it is a short decimal.
std::string format_duration(Nanos duration);  // precondition: >= 0
std::string format_rate(Rate rate);
std::string format_percentage(double fraction);

}  // namespace ctn::config
