#include "flight/late_watch.h"

#include <algorithm>
#include <utility>

#include "base/result.h"
#include "plan/json.h"
#include "plan/plan.h"

namespace ctn::flight {

LateWatch::LateWatch(const graph::App& app, const std::vector<WatchedChain>& chains, TimePoint from)
    : app_(app), from_(from) {
  for (const WatchedChain& watched : chains) {
    const graph::Term& term = app.objective[watched.term];
    chains_.push_back({watched, record::ChainTracker(app.graph, term.path), term.max, std::nullopt});
  }
}

std::optional<Nanos> LateWatch::Chain::asked_or_promised() const {
  if (watched.over) return watched.over;
  return bound ? bound : promised;
}

std::optional<LateResponse> LateWatch::take() { return std::exchange(worst_, std::nullopt); }

void LateWatch::add(const record::Run& run) {
  for (Chain& chain : chains_) {
    for (const record::ChainSample& sample : chain.tracker.add(run)) {
      const std::optional<Nanos> allowed = chain.asked_or_promised();
      if (!sample.response || !allowed || *sample.response <= *allowed || sample.begin < from_) continue;
      const LateResponse late{chain.watched.term, *sample.response, *allowed, sample.begin + *sample.response};
      ++count_;
      if (!worst_ || late.response - late.over > worst_->response - worst_->over) worst_ = late;
    }
  }
}

// A plan that cannot be read promises nothing.
void LateWatch::add(const record::PlanChange& change) {
  const Result<plan::Plan> plan = plan::from_json(change.json, app_, "the plan in force");
  for (Chain& chain : chains_) {
    chain.promised.reset();
    if (!plan) continue;
    const auto planned = std::find_if(plan->chains.begin(), plan->chains.end(), [&](const plan::ChainPlan& of_plan) {
      return of_plan.path == app_.objective[chain.watched.term].path;
    });
    if (planned != plan->chains.end()) chain.promised = to_nanos(planned->response);
  }
}

void LateWatch::add(const record::AppChange& change) {
  if (change.what != record::AppChange::What::kMax) return;
  for (Chain& chain : chains_) {
    if (chain.watched.term != change.item) continue;
    chain.bound = change.after ? std::optional(to_nanos(Millis{*change.after})) : std::nullopt;
  }
}

void LateWatch::add(const record::ClockReading& reading) {
  for (Chain& chain : chains_) chain.tracker.set_clock(reading.node, reading.ticks);
}

}  // namespace ctn::flight
