#include "policy/paper.h"

#include <utility>

#include "paper/paper.h"

namespace ctn::policy {
namespace {

// Of each stage while an app runs: some tens of milliseconds at most for an app of a few subchains.
constexpr std::size_t kSteps = 300'000;

// `allocated`: whose cores are kept, by stage II alone; may be null.
Result<Decision> decide_by_paper(const Situation& situation, const plan::Plan* allocated) {
  const graph::App app = paper::as_in_the_paper(situation.app);
  const Situation in_the_paper{.app = app,
                               .cpus = situation.cpus,
                               .costs = situation.costs,
                               .typical = situation.typical,
                               .slack = situation.slack,
                               .stealing = situation.stealing,
                               .assumed = situation.assumed};
  return decide_in_any_case(in_the_paper, [&](const graph::App& of, const model::CostTable& costs, bool) {
    paper::Request request{.cores = static_cast<int>(situation.cpus.size()),
                           .slack = situation.slack,
                           .steps = kSteps,
                           .allocated = allocated};
    Result<plan::Plan> plan = paper::make_plan(of, costs, request);
    if (plan || !request.allocated) return plan;
    // Where exact rates do not fit the cores that are kept, others may do.
    request.allocated = nullptr;
    return paper::make_plan(of, costs, request);
  });
}

}  // namespace

Result<Decision> PaperPolicy::decide(const Situation& situation) const { return decide_by_paper(situation, nullptr); }

Result<std::optional<Decision>> PaperPolicy::decide_again(const Situation& situation, const Decision& in_force) const {
  const bool keeps_cores =
      situation.periodic % kStageOneEvery != 0 && in_force.plan && in_force.plan->cores.size() == situation.cpus.size();
  Result<Decision> decision = decide_by_paper(situation, keeps_cores ? &*in_force.plan : nullptr);
  if (!decision) return decision.error();
  return std::optional(std::move(*decision));
}

}  // namespace ctn::policy
