// Callbacks that a program makes anew: it subscribes again, or a nodelet is unloaded and loaded again. Each time it is
// another callback to the observation; to the binding, which knows names alone, it is the same.
//
// Thread safety: pure functions.
#pragma once

#include <string>
#include <vector>

#include "common/observation.h"

namespace catan_ros {

// Of one program, and of one name: a binding means either.
bool same_callback(const ObservedCallback& a, const ObservedCallback& b);

struct MergedCallbacks {
  std::vector<ObservedCallback> callbacks{};
  std::vector<std::string> remarks{};  // of what was merged
};

// Callbacks of one name, of which each was called only when the one before was no more, become one, which has all their
// runs. Where runs of any two are among one another they are several at a time, and stay as they are. So do those that
// were not called, and services, which are no nodes.
MergedCallbacks merge_repeated(std::vector<ObservedCallback> callbacks);

}  // namespace catan_ros
