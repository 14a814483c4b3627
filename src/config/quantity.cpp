#include "config/quantity.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>

#include "base/text.h"

namespace ctn::config {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr std::array<Unit, 4> kDurationUnits{{{"ns", 1.0}, {"us", 1e3}, {"ms", 1e6}, {"s", 1e9}}};
constexpr std::array<Unit, 2> kRateUnits{{{"Hz", 1.0}, {"kHz", 1e3}}};
constexpr std::array<Unit, 1> kPercentUnits{{{"%", 1.0}}};
constexpr std::array<Unit, 1> kGrowthUnits{{{"%/s", 1.0}}};

constexpr double kLongestNanos = 10.0 * 24 * 3600 * 1e9;
constexpr double kLowestHertz = 1e-5;
constexpr double kHighestHertz = 1e6;
constexpr double kMaxGrowth = 1000.0;  // percent a second

bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct Parts {
  double number = 0.0;
  std::string_view number_text;
  std::string_view unit;
};

// "12.5 ms" -> 12.5 and "ms". A number is digits with at most one point inside: no sign, no exponent, no hexadecimal.
std::optional<Parts> split(std::string_view text) {
  std::size_t length = 0;
  int points = 0;
  while (length < text.size() && (is_digit(text[length]) || text[length] == '.')) {
    if (text[length] == '.') ++points;
    ++length;
  }
  Parts parts;
  parts.number_text = text.substr(0, length);
  if (length == 0 || points > 1 || !is_digit(text[0]) || !is_digit(text[length - 1])) return std::nullopt;
  const auto [end, status] = std::from_chars(text.data(), text.data() + length, parts.number);
  if (status != std::errc{} || end != text.data() + length) return std::nullopt;
  parts.unit = text.substr(length);
  while (!parts.unit.empty() && parts.unit.front() == ' ') parts.unit.remove_prefix(1);
  return parts;
}

bool same_letters(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (lower(a[i]) != lower(b[i])) return false;
  }
  return true;
}

// The number in the units' base. `what` and `example` are for the errors: "a duration", "20ms"; `usual` is the unit
// that a bare number most likely lacks.
Result<double> parse(std::string_view text, std::span<const Unit> units, std::string_view what,
                     std::string_view example, std::string (*with_unit)(const std::string& number)) {
  const std::string hint = fmt::format("write it as in {}", example);
  const auto parts = split(text);
  if (!parts) {
    if (text.starts_with('-') && split(text.substr(1))) {
      return Error::caller(fmt::format("{} is negative", quote(text)), hint);
    }
    return Error::caller(fmt::format("{} is not {}", quote(text), what), hint);
  }
  if (parts->unit.empty()) {
    const std::string number(parts->number_text);
    return Error::caller(fmt::format("{} has no unit", quote(text)), number.size() > 20 ? hint : with_unit(number));
  }
  for (const Unit& unit : units) {
    if (parts->unit == unit.name) return parts->number * unit.factor;
  }
  for (const Unit& unit : units) {
    if (!same_letters(parts->unit, unit.name) || parts->number_text.size() > 20) continue;
    return Error::caller(fmt::format("{} is no unit of {}", quote(parts->unit), what),
                         fmt::format("write {}{}", parts->number_text, unit.name));
  }
  return Error::caller(fmt::format("{} is no unit of {}", quote(parts->unit), what), hint);
}

// Shortest decimal without an exponent that reads back as the same number, which is finite: at most 309 digits before
// the point, or 323 zeros and 17 digits behind it.
std::string decimal(double value) {
  std::array<char, 400> buffer{};
  const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed);
  return {buffer.data(), written.ptr};
}

}  // namespace

Result<Nanos> parse_duration(std::string_view text) {
  const auto nanos = parse(text, kDurationUnits, "a duration", "20ms (units: ns, us, ms, s)",
                           [](const std::string& number) { return fmt::format("write {0}ms (or {0}s)", number); });
  if (!nanos) return nanos.error();
  if (*nanos > kLongestNanos) return Error::caller(fmt::format("{} is more than 10 days", quote(text)), "write less");
  const Nanos whole{std::llround(*nanos)};
  if (whole == Nanos::zero() && *nanos > 0.0) {
    return Error::caller(fmt::format("{} is less than a nanosecond", quote(text)), "write 0ms, or at least 1ns");
  }
  return whole;
}

Result<Rate> parse_rate(std::string_view text) {
  const auto hertz = parse(text, kRateUnits, "a rate", "50Hz (units: Hz, kHz)",
                           [](const std::string& number) { return fmt::format("write {}Hz", number); });
  if (!hertz) return hertz.error();
  if (*hertz < kLowestHertz || *hertz > kHighestHertz) {
    return Error::caller(fmt::format("{} is out of range", quote(text)), "write a rate from 0.00001Hz to 1000kHz");
  }
  return Rate{*hertz};
}

Result<double> parse_percentage(std::string_view text) {
  const auto percent = parse(text, kPercentUnits, "a percentage", "6%", [](const std::string& number) {
    const double value = std::strtod(number.c_str(), nullptr);
    return value > 0.0 && value < 1.0 ? fmt::format("write {:.6g}%", value * 100.0) : fmt::format("write {}%", number);
  });
  if (!percent) return percent.error();
  if (*percent >= 100.0) return Error::caller(fmt::format("{} is out of range", quote(text)), "write less than 100%");
  return *percent / 100.0;
}

Result<double> parse_growth(std::string_view text) {
  const auto percent = parse(text, kGrowthUnits, "a growth", "0.5%/s",
                             [](const std::string& number) { return fmt::format("write {}%/s", number); });
  if (!percent) return percent.error();
  if (*percent > kMaxGrowth) {
    return Error::caller(fmt::format("{} is out of range", quote(text)), "write at most 1000%/s");
  }
  return *percent / 100.0;
}

std::string format_duration(Nanos duration) {
  const long long nanos = duration.count();
  const auto in = [&](long long unit, int digits, std::string_view name) {
    std::string text = fmt::format("{}.{:0{}}", nanos / unit, nanos % unit, digits);
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text.append(name);
  };
  if (nanos == 0) return "0ms";
  if (nanos < 1'000) return fmt::format("{}ns", nanos);
  if (nanos < 1'000'000) return in(1'000, 3, "us");
  if (nanos < 1'000'000'000) return in(1'000'000, 6, "ms");
  return in(1'000'000'000, 9, "s");
}

std::string format_rate(Rate rate) { return decimal(rate.hertz()) + "Hz"; }

std::string format_percentage(double fraction) {
  // A fraction is a percentage divided by 100; of the candidates next to fraction * 100, one restores it exactly.
  for (const double percent :
       {fraction * 100.0, std::nextafter(fraction * 100.0, 0.0), std::nextafter(fraction * 100.0, 100.0)}) {
    if (percent / 100.0 == fraction) return decimal(percent) + "%";
  }
  return decimal(fraction * 100.0) + "%";
}

}  // namespace ctn::config
