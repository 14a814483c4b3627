#include "config/quantity.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace ctn::config {
namespace {

using namespace std::chrono_literals;

template <class T>
std::string fault(const Result<T>& result) {
  return result.ok() ? "" : to_string(result.error().problems().front());
}

TEST(Duration, TakesUnitsAndFractions) {
  EXPECT_EQ(*parse_duration("8.33ms"), 8'330'000ns);
  EXPECT_EQ(*parse_duration("20us"), 20us);
  EXPECT_EQ(*parse_duration("1.5 s"), 1500ms);
  EXPECT_EQ(*parse_duration("100ns"), 100ns);
  EXPECT_EQ(*parse_duration("0ms"), 0ns);
  EXPECT_EQ(*parse_duration("864000s"), 240h);
}

TEST(Duration, RefusesTheRestAndSaysWhatWouldBeRight) {
  EXPECT_EQ(fault(parse_duration("20")), "'20' has no unit; write 20ms (or 20s)");
  EXPECT_EQ(fault(parse_duration("-5ms")), "'-5ms' is negative; write it as in 20ms (units: ns, us, ms, s)");
  EXPECT_EQ(fault(parse_duration("20MS")), "'MS' is no unit of a duration; write 20ms");
  EXPECT_EQ(fault(parse_duration("0.4ns")), "'0.4ns' is less than a nanosecond; write 0ms, or at least 1ns");
  EXPECT_EQ(fault(parse_duration("864001s")), "'864001s' is more than 10 days; write less");
  for (const char* text : {"", " ", "ms", "fast", ".5ms", "5.ms", "1.2.3ms", "0x10ms", "1e3ms", "infms", "nanms",
                           " 5ms", "5ms ", "+5ms", "5 m s", "5\tms", "5min", "5Hz"}) {
    EXPECT_FALSE(parse_duration(text).ok()) << text;
  }
  EXPECT_FALSE(parse_duration(std::string(5000, '9') + "ms").ok());
  EXPECT_FALSE(parse_duration(std::string_view("5\0ms", 4)).ok());
}

TEST(Rates, AreInRange) {
  EXPECT_EQ(parse_rate("50Hz")->hertz(), 50.0);
  EXPECT_EQ(parse_rate("1.5kHz")->hertz(), 1500.0);
  EXPECT_EQ(parse_rate("0.00001Hz")->hertz(), 1e-5);
  EXPECT_EQ(fault(parse_rate("50")), "'50' has no unit; write 50Hz");
  EXPECT_EQ(fault(parse_rate("50hz")), "'hz' is no unit of a rate; write 50Hz");
  EXPECT_EQ(fault(parse_rate("0Hz")), "'0Hz' is out of range; write a rate from 0.00001Hz to 1000kHz");
  EXPECT_FALSE(parse_rate("1001kHz").ok());
  EXPECT_FALSE(parse_rate("0.000001Hz").ok());
}

TEST(Percentages, AreFractionsBelowOne) {
  EXPECT_EQ(*parse_percentage("6%"), 0.06);
  EXPECT_EQ(*parse_percentage("0%"), 0.0);
  EXPECT_EQ(fault(parse_percentage("6")), "'6' has no unit; write 6%");
  EXPECT_EQ(fault(parse_percentage("0.06")), "'0.06' has no unit; write 6%");
  EXPECT_EQ(fault(parse_percentage("100%")), "'100%' is out of range; write less than 100%");
}

TEST(Growth, IsAPercentageASecond) {
  EXPECT_EQ(*parse_growth("0.5%/s"), 0.005);
  EXPECT_EQ(*parse_growth("1000 %/s"), 10.0);
  EXPECT_EQ(fault(parse_growth("0.5")), "'0.5' has no unit; write 0.5%/s");
  EXPECT_EQ(fault(parse_growth("0.5%")), "'%' is no unit of a growth; write it as in 0.5%/s");
  EXPECT_EQ(fault(parse_growth("-1%/s")), "'-1%/s' is negative; write it as in 0.5%/s");
  EXPECT_EQ(fault(parse_growth("1001%/s")), "'1001%/s' is out of range; write at most 1000%/s");
}

TEST(Format, IsShort) {
  EXPECT_EQ(format_duration(8'330'000ns), "8.33ms");
  EXPECT_EQ(format_duration(20us), "20us");
  EXPECT_EQ(format_duration(2s), "2s");
  EXPECT_EQ(format_duration(667ms), "667ms");
  EXPECT_EQ(format_duration(7ns), "7ns");
  EXPECT_EQ(format_duration(0ns), "0ms");
  EXPECT_EQ(format_rate(Rate{120.0}), "120Hz");
  EXPECT_EQ(format_percentage(0.06), "6%");
  EXPECT_EQ(format_percentage(1e-70), "0." + std::string(67, '0') + "1%");  // without an exponent, which is not read
}

RC_GTEST_PROP(QuantityProperty, DurationsSurvivePrinting, ()) {
  const auto magnitude = *rc::gen::inRange(0, 50);
  const Nanos duration{*rc::gen::inRange<std::int64_t>(0, (std::int64_t{1} << magnitude) + 1) % 864'000'000'000'000};
  const auto again = parse_duration(format_duration(duration));
  RC_ASSERT(again.ok());
  RC_ASSERT(*again == duration);
}

RC_GTEST_PROP(QuantityProperty, RatesSurvivePrinting, ()) {
  const double exponent = *rc::gen::inRange(-4'999, 5'999) / 1000.0;
  const Rate rate{std::pow(10.0, exponent)};
  const auto again = parse_rate(format_rate(rate));
  RC_ASSERT(again.ok());
  RC_ASSERT(*again == rate);
}

RC_GTEST_PROP(QuantityProperty, PercentagesSurvivePrinting, ()) {
  const auto fraction = parse_percentage(fmt::format("{}%", *rc::gen::inRange(0, 99'999) / 1000.0));
  RC_ASSERT(fraction.ok());
  const auto again = parse_percentage(format_percentage(*fraction));
  RC_ASSERT(again.ok());
  RC_ASSERT(*again == *fraction);
}

RC_GTEST_PROP(QuantityProperty, NoTextCrashes, (const std::string& text)) {
  for (const char* unit : {"", "ms", "Hz", "%"}) {
    (void)parse_duration(text + unit);
    (void)parse_rate(text + unit);
    (void)parse_percentage(text + unit);
  }
}

}  // namespace
}  // namespace ctn::config
