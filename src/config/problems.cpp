#include "config/problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

namespace ctn::config {

void Problems::add(const Place& place, const std::string& key, const Error& error) {
  for (const Problem& problem : error.problems()) add(place, key, problem.what, problem.hint);
}

void Problems::merge(const Error& error) {
  std::set<std::string> known;
  for (const Problem& problem : list_) known.insert(problem.key);
  for (const Problem& problem : error.problems()) {
    if (!known.contains(problem.key)) list_.push_back(problem);
  }
}

Error Problems::to_error() && {
  constexpr std::size_t kMax = 100;
  std::stable_sort(list_.begin(), list_.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.place.line, a.place.column) < std::tie(b.place.line, b.place.column);
  });
  if (list_.size() > kMax) {
    const std::size_t more = list_.size() - kMax;
    const Place place = list_[kMax].place;
    list_.resize(kMax);
    add(place, "", fmt::format("{} more problems from here on", more), "fix those above first");
  }
  return {ErrorKind::kCaller, std::move(list_)};
}

}  // namespace ctn::config
