#include "view/late_causes.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "why/why.h"

namespace ctn::view {
namespace {

TimePoint time_of(const record::Run& run) { return run.end; }
TimePoint time_of(const record::Trigger& trigger) { return trigger.sent; }
TimePoint time_of(const record::SlotUse& slot) { return slot.end; }
TimePoint time_of(const record::Steal& steal) { return steal.end; }
TimePoint time_of(const record::ClockReading& reading) { return reading.at; }
TimePoint time_of(const record::PlanChange& change) { return change.at; }

// Passes over a plan that cannot be read: what only it could explain stays unexplained.
template <class Event>
void hand_to(why::Analyser& analyser, const Event& event) {
  if constexpr (std::is_same_v<Event, record::PlanChange>) {
    static_cast<void>(analyser.add(event));
  } else {
    analyser.add(event);
  }
}

}  // namespace

LateCauses::LateCauses(const graph::App& app, std::size_t cpus)
    : terms_(why::chains_of(app)), cpus_(cpus), told_(terms_.size()), so_far_(terms_.size()), before_(terms_.size()) {}

void LateCauses::go_on_from(const std::vector<SoFar>& other) {
  if (other.size() != terms_.size()) return;
  so_far_ = other;
  for (std::size_t chain = 0; chain < terms_.size(); ++chain) before_[chain] = other[chain].until;
}

void LateCauses::keep(Event event) {
  newest_ = std::max(newest_, std::visit([](const auto& of) { return time_of(of); }, event));
  events_.push_back(std::move(event));
  const auto is_old = [&](const Event& of) {
    return std::visit([](const auto& one) { return time_of(one); }, of) < newest_ - kKept;
  };
  while (!events_.empty() && (events_.size() > kMaxKept || is_old(events_.front()))) forget_oldest();
}

void LateCauses::forget_oldest() {
  if (auto* const plan = std::get_if<record::PlanChange>(&events_.front())) plan_ = std::move(*plan);
  if (auto* const reading = std::get_if<record::ClockReading>(&events_.front())) {
    clocks_.insert_or_assign(reading->node, *reading);
  }
  events_.pop_front();
}

void LateCauses::late(std::size_t chain, TimePoint begin, TimePoint end) {
  if (end <= before_[chain]) return;
  waiting_.push_back({chain, begin, end});
  if (waiting_.size() <= kMaxWaiting) return;
  tell(waiting_.front().chain, waiting_.front().end, why::CauseKind::kUnexplained);
  waiting_.pop_front();
}

void LateCauses::look(const graph::App& app) {
  if (waiting_.empty() || waiting_.front().end > newest_ - kSettled) return;
  if (looked_ && *looked_ > newest_ - kEvery) return;
  explain(app, newest_ - kSettled);
}

void LateCauses::lost(const graph::App& app) {
  look_at_all(app);
  events_.clear();
  clocks_.clear();
}

void LateCauses::explain(const graph::App& app, TimePoint by) {
  if (waiting_.empty()) return;
  looked_ = newest_;
  std::vector<std::vector<why::Span>> late(terms_.size());
  std::vector<Waiting> left;
  for (const Waiting& one : waiting_) {
    if (one.end > by) {
      left.push_back(one);
    } else {
      late[one.chain].push_back({one.begin, one.end});
    }
  }
  std::vector<std::size_t> terms;
  std::vector<std::size_t> chains;
  for (std::size_t chain = 0; chain < terms_.size(); ++chain) {
    if (late[chain].empty()) continue;
    terms.push_back(terms_[chain]);
    chains.push_back(chain);
  }
  waiting_.assign(left.begin(), left.end());
  if (terms.empty()) return;
  why::Analyser analyser(app, terms, cpus_, {});
  if (plan_) hand_to(analyser, *plan_);
  for (const auto& [node, reading] : clocks_) hand_to(analyser, reading);
  for (const Event& event : events_) std::visit([&](const auto& of) { hand_to(analyser, of); }, event);
  std::vector<std::vector<why::Span>> asked;
  for (const std::size_t chain : chains) asked.push_back(late[chain]);
  const std::vector<std::vector<why::CauseKind>> causes = analyser.causes_of(asked);
  for (std::size_t place = 0; place < chains.size(); ++place) {
    for (std::size_t one = 0; one < asked[place].size(); ++one) {
      tell(chains[place], asked[place][one].end, causes[place][one]);
    }
  }
}

void LateCauses::tell(std::size_t chain, TimePoint end, why::CauseKind cause) {
  SoFar& so_far = so_far_[chain];
  ++so_far.counts[static_cast<std::size_t>(cause)];
  so_far.until = std::max(so_far.until, end);
  std::deque<Told>& told = told_[chain];
  told.push_back({end, cause});
  while (!told.empty() && (told.front().end < newest_ - kKept || told.size() > kMaxWaiting)) told.pop_front();
}

}  // namespace ctn::view
