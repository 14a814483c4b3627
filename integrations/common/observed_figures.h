// Figures of what was observed of callbacks (observation.h), and how they are written in app and cost files.
//
// Thread safety: pure functions.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/observation.h"

namespace catan_ros {

// Nothing costs less.
inline constexpr std::chrono::nanoseconds kMinCost = std::chrono::microseconds{1};

// CPU time of a run, of which that part of the runs takes less. Precondition: there are runs.
std::chrono::nanoseconds cost_percentile(const ObservedCallback& callback, double part);
// Between the begins of runs, the median, and the mean; none: there are not two.
std::optional<std::chrono::nanoseconds> median_interval(const ObservedCallback& callback);
std::optional<std::chrono::nanoseconds> mean_interval(const ObservedCallback& callback);
// The period of what comes at these times, where it comes regularly; none: it does not, or too seldom.
std::optional<std::chrono::nanoseconds> clock_of(const std::vector<std::chrono::nanoseconds>& times);

// Without what is no data of the app, as subscriptions and where it is published: clocks, logs, transforms, and
// messages by which nodelets and their manager tell each other that they live.
std::vector<ObservedCallback> of_data(std::vector<ObservedCallback> callbacks);
// Anything at all; in how many runs, on a topic.
bool publishes(const ObservedCallback& callback);
std::size_t count_published(const ObservedCallback& callback, const std::string& topic);
// It publishes nothing and takes next to no time. Precondition: there are runs.
bool is_light(const ObservedCallback& callback);
// "/mapper's subscription of /scan", or "nodelet /turn's subscription of /image".
std::string described(const ObservedCallback& callback);

std::string duration_text(std::chrono::nanoseconds time);  // with three decimals at most, and kMinCost at least
std::string exact_text(std::chrono::nanoseconds time);
std::string rate_text(std::chrono::nanoseconds period);

}  // namespace catan_ros
