#include "runtime/assignment.h"

#include <algorithm>
#include <utility>

#include "runtime/replan.h"

namespace ctn::runtime {
namespace {

SubchainPlace place_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus, SubchainId id) {
  const plan::SubchainPlan& planned = plan.subchains[id.index()];
  SubchainPlace place;
  std::vector<int> numbers;
  for (const int core : planned.cores) numbers.push_back(cpus.cpus()[static_cast<std::size_t>(core)]);
  place.cpus = os::CpuSet(std::move(numbers));
  if (plan::shares_core(plan, planned)) {
    place.core = planned.cores.front();
  } else {
    place.pacing = pacing_of(app, plan, id);
    place.level = os::Level::kActive;
  }
  return place;
}

}  // namespace

Assignment assignment_of(const graph::App& app, const plan::Plan& plan, const os::CpuSet& cpus,
                         const AssignmentOptions& options) {
  Assignment assignment;
  for (std::size_t index = 0; index < plan.subchains.size(); ++index) {
    assignment.places.push_back(place_of(app, plan, cpus, SubchainId(index)));
  }
  const dispatch::ScheduleOptions schedule{
      .stealing = options.stealing, .hang_multiple = kHangMultiple, .shortest_hang = kShortestHang};
  for (std::size_t core = 0; core < plan.cores.size(); ++core) {
    assignment.cores.push_back(dispatch::shared_core_schedule(app, plan, static_cast<int>(core), schedule));
  }
  return assignment;
}

AssignmentBoard::AssignmentBoard(std::size_t readers) : seen_(readers) {}

void AssignmentBoard::publish(Assignment assignment) {
  assignment.number = ++published_;
  kept_.push_back(std::make_unique<const Assignment>(std::move(assignment)));
  latest_.store(kept_.back().get(), std::memory_order_release);
  // A reader that is just loading one has not said so yet: it may load what was the newest when it looked last, or
  // anything since.
  std::uint64_t oldest = published_;
  for (const std::atomic<std::uint64_t>& seen : seen_) oldest = std::min(oldest, seen.load(std::memory_order_acquire));
  while (kept_.front()->number < oldest) kept_.pop_front();
}

const Assignment& AssignmentBoard::look(std::size_t reader) {
  const Assignment* const latest = latest_.load(std::memory_order_acquire);
  seen_[reader].store(latest->number, std::memory_order_release);
  return *latest;
}

}  // namespace ctn::runtime
