#include "common/observed_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

namespace catan_ros {
namespace {

using std::chrono::nanoseconds;

// Half of the runs are below that of a callback that does no more than keep a message.
constexpr nanoseconds kKeepsOnly = std::chrono::microseconds{300};
constexpr std::size_t kRunsForAPeriod = 10;
// A tenth of the intervals may be that part of the median away from it, where there is a clock.
constexpr double kRegular = 0.25;
constexpr std::array<std::string_view, 5> kNoData{"/rosout", "/rosout_agg", "/clock", "/tf", "/tf_static"};
constexpr std::string_view kSignsOfLife = "bond/Status";  // the type of their messages; topics have any names

// Precondition: there are some.
nanoseconds percentile(std::vector<nanoseconds> values, double part) {
  const auto rank = static_cast<std::size_t>(std::ceil(part * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<nanoseconds> intervals(std::vector<nanoseconds> times) {
  std::sort(times.begin(), times.end());
  std::adjacent_difference(times.begin(), times.end(), times.begin());
  if (!times.empty()) times.erase(times.begin());
  return times;
}

// With three decimals at most.
std::string decimal(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f", value);
  std::string shown = text.data();
  shown.erase(shown.find_last_not_of('0') + 1);
  if (shown.back() == '.') shown.pop_back();
  return shown;
}

}  // namespace

nanoseconds cost_percentile(const ObservedCallback& callback, double part) {
  std::vector<nanoseconds> costs;
  for (const ObservedRun& run : callback.runs) costs.push_back(run.cpu_time);
  return percentile(std::move(costs), part);
}

std::optional<nanoseconds> median_interval(const ObservedCallback& callback) {
  if (callback.runs.size() < 2) return std::nullopt;
  std::vector<nanoseconds> begins;
  for (const ObservedRun& run : callback.runs) begins.push_back(run.begin);
  return std::max(percentile(intervals(std::move(begins)), 0.5), kMinCost);
}

std::optional<nanoseconds> mean_interval(const ObservedCallback& callback) {
  if (callback.runs.size() < 2) return std::nullopt;
  const auto earlier = [](const ObservedRun& a, const ObservedRun& b) { return a.begin < b.begin; };
  const auto [first, last] = std::minmax_element(callback.runs.begin(), callback.runs.end(), earlier);
  return std::max((last->begin - first->begin) / static_cast<std::int64_t>(callback.runs.size() - 1), kMinCost);
}

std::optional<nanoseconds> clock_of(const std::vector<nanoseconds>& times) {
  if (times.size() < kRunsForAPeriod) return std::nullopt;
  const std::vector<nanoseconds> between = intervals(times);
  const nanoseconds median = percentile(between, 0.5);
  const auto off = std::chrono::duration_cast<nanoseconds>(median * kRegular);
  const bool regular = percentile(between, 0.1) >= median - off && percentile(between, 0.9) <= median + off;
  return regular && median >= kMinCost ? std::optional(median) : std::nullopt;
}

std::vector<ObservedCallback> of_data(std::vector<ObservedCallback> callbacks) {
  std::set<std::string_view> no_data(kNoData.begin(), kNoData.end());
  std::set<std::string> signs_of_life;
  for (const ObservedCallback& callback : callbacks) {
    const bool is_topic = callback.kind == Binding::Kind::kTopic;
    if (is_topic && callback.type == kSignsOfLife) signs_of_life.insert(callback.name);
  }
  no_data.insert(signs_of_life.begin(), signs_of_life.end());
  const auto is_none = [&](const std::string& topic) { return no_data.count(topic) > 0; };
  std::vector<ObservedCallback> kept;
  for (ObservedCallback& callback : callbacks) {
    if (callback.kind == Binding::Kind::kTopic && is_none(callback.name)) continue;
    for (ObservedRun& run : callback.runs) {
      run.published.erase(std::remove_if(run.published.begin(), run.published.end(), is_none), run.published.end());
    }
    kept.push_back(std::move(callback));
  }
  return kept;
}

bool publishes(const ObservedCallback& callback) {
  return std::any_of(callback.runs.begin(), callback.runs.end(),
                     [](const ObservedRun& run) { return !run.published.empty(); });
}

std::size_t count_published(const ObservedCallback& callback, const std::string& topic) {
  const auto published = [&](const ObservedRun& run) {
    return std::find(run.published.begin(), run.published.end(), topic) != run.published.end();
  };
  return static_cast<std::size_t>(std::count_if(callback.runs.begin(), callback.runs.end(), published));
}

bool is_light(const ObservedCallback& callback) {
  return !publishes(callback) && cost_percentile(callback, 0.5) < kKeepsOnly;
}

std::string described(const ObservedCallback& callback) {
  const std::string who = (callback.nodelet.empty() ? "" : "nodelet ") + program_of(callback) + "'s ";
  if (callback.kind == Binding::Kind::kTimer) return who + "timer of " + exact_text(callback.period);
  return who + (callback.kind == Binding::Kind::kTopic ? "subscription of " : "service ") + callback.name;
}

std::string duration_text(nanoseconds time) {
  return decimal(static_cast<double>(std::max(time, kMinCost).count()) * 1e-6) + "ms";
}

// What roscpp compares periods with: to the nanosecond.
std::string exact_text(nanoseconds time) {
  if (time.count() % 1'000'000 == 0) return std::to_string(time.count() / 1'000'000) + "ms";
  if (time.count() % 1'000 == 0) return std::to_string(time.count() / 1'000) + "us";
  return std::to_string(time.count()) + "ns";
}

std::string rate_text(nanoseconds period) {
  return decimal(std::max(1e9 / static_cast<double>(period.count()), 0.001)) + "Hz";
}

}  // namespace catan_ros
