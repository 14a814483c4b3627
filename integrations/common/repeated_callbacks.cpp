#include "common/repeated_callbacks.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "common/observed_figures.h"

namespace catan_ros {
namespace {

// Runs are in the order in which they ended. Precondition: both have some.
bool have_runs_among_one_another(const ObservedCallback& a, const ObservedCallback& b) {
  return a.runs.front().begin <= b.runs.back().begin && b.runs.front().begin <= a.runs.back().begin;
}

bool may_be_merged(const ObservedCallback& callback) {
  return callback.kind != Binding::Kind::kService && !callback.runs.empty();
}

// Of the same name as that one, in the order of their runs; itself among them.
std::vector<ObservedCallback*> of_same_name(std::vector<ObservedCallback>& callbacks, const ObservedCallback& one) {
  std::vector<ObservedCallback*> alike;
  for (ObservedCallback& other : callbacks) {
    if (may_be_merged(other) && same_callback(one, other)) alike.push_back(&other);
  }
  std::stable_sort(alike.begin(), alike.end(), [](const ObservedCallback* a, const ObservedCallback* b) {
    return a->runs.front().begin < b->runs.front().begin;
  });
  return alike;
}

}  // namespace

bool same_callback(const ObservedCallback& a, const ObservedCallback& b) {
  return of_one_program(a, b) && a.kind == b.kind && a.name == b.name && a.period == b.period;
}

MergedCallbacks merge_repeated(std::vector<ObservedCallback> callbacks) {
  MergedCallbacks merged;
  std::vector<const ObservedCallback*> gone;
  for (ObservedCallback& callback : callbacks) {
    if (std::find(gone.begin(), gone.end(), &callback) != gone.end()) continue;
    if (may_be_merged(callback)) {
      const std::vector<ObservedCallback*> alike = of_same_name(callbacks, callback);
      const bool at_a_time = std::adjacent_find(alike.begin(), alike.end(), [](const auto* a, const auto* b) {
                               return have_runs_among_one_another(*a, *b);
                             }) != alike.end();
      if (alike.size() > 1 && !at_a_time) {
        std::vector<ObservedRun> runs;
        for (const ObservedCallback* const one : alike) {
          runs.insert(runs.end(), one->runs.begin(), one->runs.end());
          gone.push_back(one);
        }
        callback.runs = std::move(runs);
        merged.remarks.push_back(described(callback) + " is there more than once; the first is the node");
      }
    }
    merged.callbacks.push_back(callback);
  }
  return merged;
}

}  // namespace catan_ros
