#include "common/node_runs.h"

#include <algorithm>

namespace catan_ros {

void NodeRuns::begin() {
  taken_.clear();
  kept_.clear();
  node_.begin(run_);
}

// What a run of another node sent counts only when that has ended: by now it may have.
void NodeRuns::end(bool output) {
  for (const Taken& one : taken_) node_.take(run_, one.from, one.first, one.last);
  for (const Kept& one : kept_) {
    if (find(one.from) == taken_.end()) node_.take(run_, one.from, one.run, one.run);
  }
  if (!output) run_.skip_output();
  node_.end(run_);
}

void NodeRuns::take(const std::string& from, std::uint64_t run) {
  const auto known = find(from);
  Taken& taken = known != taken_.end() ? *known : taken_.emplace_back(Taken{from, run, run});
  taken.first = std::min(taken.first, run);
  taken.last = std::max(taken.last, run);
  node_.take(run_, from, taken.first, taken.last);
}

void NodeRuns::let_go(const std::string& from, std::uint64_t run) {
  const auto known = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& one) { return one.from == from; });
  Kept& kept = known != kept_.end() ? *known : kept_.emplace_back(Kept{from, run, true});
  kept.run = kept.let_go ? std::max(kept.run, run) : run;
  kept.let_go = true;
}

std::vector<NodeRuns::Taken>::iterator NodeRuns::find(const std::string& from) {
  return std::find_if(taken_.begin(), taken_.end(), [&](const Taken& one) { return one.from == from; });
}

}  // namespace catan_ros
