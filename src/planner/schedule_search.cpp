#include "planner/schedule_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "model/portable_math.h"
#include "planner/clock_phases.h"

namespace ctn::planner {
namespace {

using trial::Place;
using trial::Schedule;

constexpr std::size_t kCandidates = 5;
// To try them all again would use up the time in which others could be found.
constexpr std::size_t kKeptAtNewCosts = 2;
constexpr std::size_t kMaxBeginnings = 16;
constexpr std::size_t kMinStepsABeginning = 1000;
constexpr std::size_t kSortsOfBeginnings = 3;
// At the start of the annealing, a step that makes the score worse by so much of it is taken once in e times.
constexpr double kTemperature = 0.03;
// The same, near a candidate whose score is known.
constexpr double kTemperatureNearby = 0.004;
constexpr std::size_t kStepsNearby = 400;
// How often one step at random is drawn again that formulas find worse by more than this.
constexpr std::size_t kRedraws = 20;
constexpr double kPromising = 1.02;
// Room is made on a core up to this part of what there is, by periods at most so many times as long.
constexpr double kRoomUpTo = 0.9999;
constexpr double kMaxRoom = 1.5;
// How far formulas are taken to be from how full a core is, at most.
constexpr double kMaxLoadFactor = 1.1;
// A first trial that is worse by no more is followed by the second.
constexpr double kNearlyAsGood = 1.002;
// After so many changes in vain a candidate, unless it is the best, gives way to a new beginning.
constexpr std::size_t kGiveUpAfter = 15;

// A trial is so many times as long as the slowest term, so that a mean means something.
constexpr double kTermsATrial = 8.0;
constexpr Nanos kShortestHorizon = std::chrono::seconds{4};
constexpr Nanos kLongestHorizon = std::chrono::seconds{40};
// A short trial, of this part of it, comes before; a schedule that is worse there by more than this is not tried any
// longer.
constexpr int kGlance = 6;
constexpr double kHopeless = 1.02;
// A longer trial that finds a schedule worse by no more than this confirms what those before found.
constexpr double kConfirmed = 1.02;
// Whose trial shows a core that is used too much has periods longer by as much and by this part more, at first; so many
// times at most. That is room for costs that vary, so that not each change of theirs is one of the plan, and for what
// is changed in a candidate. A plan that a caller knows needs none.
constexpr double kSlowerByMore = 0.02;
constexpr double kKnownSlowerByMore = 0.002;
constexpr int kMaxSlowings = 5;
constexpr std::uint32_t kSecondDraw = 1400;
constexpr std::uint32_t kLastDraw = 2800;
// Two periods that hardly differ keep a lucky phase for longer than a trial; not for hours.
constexpr Nanos kSecondTime = std::chrono::milliseconds{3'671'377};
constexpr Nanos kLastTime = std::chrono::milliseconds{9'473'851};

// CPU time on an ordinary machine.
Nanos work_of_guesses(std::size_t steps, std::size_t subchains) {
  return Nanos{static_cast<Nanos::rep>(steps * (100 + 150 * subchains))};
}
Nanos work_of_trial(const trial::Figures& figures) {
  constexpr Nanos kSetUp = std::chrono::microseconds{20};
  return kSetUp + Nanos{static_cast<Nanos::rep>(80 * figures.events)};
}

}  // namespace

ScheduleSearch::ScheduleSearch(const graph::App& app, const Setting& setting)
    : app_(app), setting_(setting), random_(setting.seed), scoring_(app, setting.slack) {}

void ScheduleSearch::know_clocks(std::vector<NodeId> clocks) {
  if (clocks_ == clocks) return;
  clocks_ = std::move(clocks);
  steps_in_vain_ = 0;
  if (moves_) moves_->know_clocks(clocks_);
}

bool ScheduleSearch::know_phases(const std::vector<Ticks>& clocks) {
  std::vector<Ticks> now = keep_their_phases(app_.graph, clocks) ? clocks : std::vector<Ticks>{};
  if (have_same_phases(app_.graph, phases_, now)) return false;
  phases_ = std::move(now);
  forget_trials();
  return true;
}

void ScheduleSearch::set_costs(trial::Samples samples, model::CostTable planned, const trial::Overheads& machine) {
  costs_ = std::make_unique<Costs>(app_, std::move(samples), std::move(planned), setting_.slack, machine);
  std::vector<double> costs;
  for (std::size_t i = 0; i < app_.graph.subchains().size(); ++i) {
    costs.push_back(costs_->surrogate.mean_cost(SubchainId(i), 0));
  }
  moves_.emplace(app_, std::move(costs), costs_->pipelines, setting_.cores, setting_.freedom);
  moves_->know_clocks(clocks_);
  std::erase_if(candidates_, [&](Candidate& each) { return !fixed(each) && !renew_pipelines(each.schedule); });
  std::size_t improvable = 0;
  std::erase_if(candidates_, [&](const Candidate& each) { return !fixed(each) && ++improvable > kKeptAtNewCosts; });
  for (Candidate& candidate : candidates_) {
    if (!fixed(candidate)) make_hold(candidate.schedule);
  }
  forget_trials();
}

void ScheduleSearch::forget_trials() {
  for (Candidate& candidate : candidates_) {
    candidate.tried = false;
    candidate.glance = 0.0;
    candidate.in_vain = 0;
  }
  steps_in_vain_ = 0;
}

Schedule ScheduleSearch::slowed(Schedule schedule, double factor) const {
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    Place& place = schedule.subchains[i];
    // A pause alone is made so much longer, so that it is a small step: there may be several.
    moves_->come_less_often(place, i, factor, to_millis(place.pause.value_or(place.period)));
  }
  return schedule;
}

// By formulas, with periods that are no longer than that takes; as it is, where nothing helps.
void ScheduleSearch::make_hold(Schedule& schedule) {
  for (const double factor : kSlowedBy) {
    Schedule slower = slowed(schedule, factor);
    if (guessed_score(slower) >= scoring_.overload()) continue;
    schedule = std::move(slower);
    return;
  }
}

// At these costs. False: one cannot have its exact rate any more.
bool ScheduleSearch::renew_pipelines(Schedule& schedule) const {
  for (trial::Pipeline& pipeline : schedule.pipelines) {
    std::optional<trial::Pipeline> renewed = costs_->pipelines.on(pipeline.subchain, pipeline.cores);
    if (!renewed) return false;
    pipeline = *std::move(renewed);
  }
  return true;
}

void ScheduleSearch::add(Schedule schedule, std::optional<double> relax) {
  if (!keeps_asked_triggers(schedule)) return;
  if (schedule.frames.empty()) moves_->keep_to_useful(schedule);
  // What it is worth is not known until it is tried; until then it counts for nothing. It is tried first, so that no
  // guess displaces it; one with frames, which guesses do not displace, after them.
  Candidate candidate{
      .schedule = std::move(schedule), .unbounded = 2.0 * scoring_.overload(), .given = true, .relax = relax};
  if (fixed(candidate)) {
    std::erase_if(candidates_, fixed);
    candidate.score = candidate.unbounded;
  }
  const auto same = std::find_if(candidates_.begin(), candidates_.end(),
                                 [&](const Candidate& known) { return known.schedule == candidate.schedule; });
  if (same != candidates_.end()) return;
  candidates_.push_back(std::move(candidate));
  std::stable_sort(candidates_.begin(), candidates_.end(), better);
}

bool ScheduleSearch::keeps_asked_triggers(const Schedule& schedule) const {
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    const graph::Node& head = app_.graph.node(app_.graph.subchain(SubchainId(i)).head());
    if (head.trigger != graph::TriggerBy::kArrival) continue;
    const std::optional<plan::After>& after = schedule.subchains[i].after;
    if (!after || after->node() == nullptr) return false;
  }
  return true;
}

// --- By formulas ---

void ScheduleSearch::guess(std::size_t steps, const std::function<void()>& after_each) {
  const std::size_t beginnings = std::clamp(steps / kMinStepsABeginning, std::size_t{2}, kMaxBeginnings);
  const auto known =
      std::find_if(candidates_.begin(), candidates_.end(), [](const Candidate& each) { return !each.factors.empty(); });
  // What is known of one schedule is likely to be so of others, and makes guesses comparable with what was tried.
  if (known == candidates_.end()) {
    costs_->surrogate.correct({});
  } else {
    costs_->surrogate.correct(known->factors, known->load_factor);
  }
  std::vector<Candidate> guessed;
  while (guessed.size() < beginnings) {
    if (guessed.empty() && known != candidates_.end()) {
      guessed.push_back(anneal(known->schedule, steps / beginnings, kTemperatureNearby));
    } else {
      Schedule schedule = beginning(guessed.empty());
      arrange(schedule, guessed.size() % kSortsOfBeginnings, guessed.size() > 1);
      guessed.push_back(anneal(std::move(schedule), steps / beginnings, kTemperature));
    }
    if (after_each) after_each();
  }
  for (Candidate& candidate : guessed) keep(std::move(candidate));
}

// Candidates without a trial go before those that formulas alone find worse.
void ScheduleSearch::keep(Candidate candidate) {
  candidates_.push_back(std::move(candidate));
  std::stable_sort(candidates_.begin(), candidates_.end(), better);
  std::size_t improvable = 0;
  std::erase_if(candidates_, [&](const Candidate& each) { return !fixed(each) && ++improvable > kCandidates; });
}

// Cores evenly filled, or by chance; what weighs much and costs little above the rest; each core's time in the
// proportions that are best where response times are periods (Lagrange).
Schedule ScheduleSearch::beginning(bool even) {
  const std::size_t count = app_.graph.subchains().size();
  std::vector<double> weight;
  for (std::size_t i = 0; i < count; ++i) {
    constexpr double kMinWeight = 1e-4;
    weight.push_back(std::max(app_.weight_of(SubchainId(i)), kMinWeight));
  }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  const auto cost = [&](std::size_t i, int core) { return costs_->surrogate.mean_cost(SubchainId(i), core); };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weight[a] * cost(a, 0) > weight[b] * cost(b, 0); });
  Schedule schedule{.cores = setting_.cores, .subchains = std::vector<Place>(count), .frames = {}, .pipelines = {}};
  std::vector<double> demand(static_cast<std::size_t>(setting_.cores), 0.0);
  std::vector<bool> placed(count, false);
  for (const std::size_t i : order) {
    if (placed[i]) continue;
    const std::size_t core =
        even ? static_cast<std::size_t>(std::min_element(demand.begin(), demand.end()) - demand.begin())
             : random_.below(demand.size());
    const auto place = [&](std::size_t one) {
      schedule.subchains[one].core = static_cast<int>(core);
      demand[core] += std::sqrt(weight[one] * cost(one, static_cast<int>(core)));
      placed[one] = true;
    };
    place(i);
    for (const SubchainId other : moves_->joined(i)) place(other.index());
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weight[a] / cost(a, 0) > weight[b] / cost(b, 0); });
  for (std::size_t rank = 0; rank < count; ++rank) {
    schedule.subchains[order[rank]].priority = static_cast<int>(count - rank);
  }
  for (std::size_t i = 0; i < count; ++i) {
    Place& place = schedule.subchains[i];
    const double root = std::sqrt(cost(i, place.core) / weight[i]);
    const Millis period{root * demand[static_cast<std::size_t>(place.core)] / (1.0 - setting_.slack)};
    place.period =
        moves_->exact(i) ? moves_->shortest_period(i) : std::max(to_nanos(period), moves_->shortest_period(i));
    moves_->set_asked_trigger(place, i);
  }
  return schedule;
}

// By time, as it is; in line, in the order of the chain that weighs most or of any; or in turns.
void ScheduleSearch::arrange(Schedule& schedule, std::size_t sort, bool by_chance) {
  if (sort == 1) moves_->fall_in_line(schedule, by_chance, random_);
  if (sort == 2) moves_->take_turns(schedule);
}

double ScheduleSearch::guessed_score(Schedule& schedule, double limit) {
  std::optional<Estimate> estimate = costs_->surrogate(schedule, limit);
  // It does not get better by that.
  if (estimate && estimate->load > 1.0 && estimate->objective <= limit && make_room(schedule)) {
    work_ += work_of_guesses(1, app_.graph.subchains().size());
    estimate = costs_->surrogate(schedule, limit);
  }
  if (!estimate) return 2.0 * scoring_.overload();
  if (estimate->load > 1.0) return scoring_.overload() * estimate->load;
  if (estimate->objective > limit) return kInfinity;
  if (estimate->exact_missed || !estimate->promised) return scoring_.overload();
  return relaxed_score(Scoring::with_gaps(estimate->objective, schedule, guessed_load(schedule)), estimate->relax);
}

// By core, as a part of what the slack leaves; by the formulas of the schedule that was asked about last.
std::vector<double> ScheduleSearch::guessed_load(const Schedule& schedule) const {
  std::vector<double> used(static_cast<std::size_t>(schedule.cores), 0.0);
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    const Place& place = schedule.subchains[i];
    if (place.form == trial::Form::kPriority) {
      used[static_cast<std::size_t>(place.core)] += costs_->surrogate.load(SubchainId(i));
    }
  }
  return used;
}

// By the formulas of the schedule that was asked about last. False: not much less often would be enough.
bool ScheduleSearch::make_room(Schedule& schedule) const {
  const auto cores = static_cast<std::size_t>(schedule.cores);
  const std::vector<double> used = guessed_load(schedule);
  std::vector<double> movable(cores, 0.0);
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    const Place& place = schedule.subchains[i];
    if (!moves_->may_come_less_often(place, i)) continue;
    movable[static_cast<std::size_t>(place.core)] += costs_->surrogate.load(SubchainId(i));
  }
  std::vector<double> factors(cores, 1.0);
  for (std::size_t core = 0; core < cores; ++core) {
    if (used[core] <= 1.0) continue;
    const double left = kRoomUpTo - (used[core] - movable[core]);
    if (left <= 0.0 || movable[core] > left * kMaxRoom) return false;
    factors[core] = movable[core] / left;
  }
  for (std::size_t i = 0; i < schedule.subchains.size(); ++i) {
    Place& place = schedule.subchains[i];
    const double factor = factors[static_cast<std::size_t>(place.core)];
    if (moves_->may_come_less_often(place, i))
      moves_->come_less_often(place, i, factor, costs_->surrogate.period(SubchainId(i)));
  }
  return true;
}

ScheduleSearch::Candidate ScheduleSearch::anneal(Schedule schedule, std::size_t steps, double first_temperature) {
  Candidate at{.schedule = std::move(schedule)};
  at.score = guessed_score(at.schedule);
  Candidate best = at;
  Candidate next = at;
  for (std::size_t step = 0; step < steps; ++step) {
    next.schedule = at.schedule;
    moves_->change(next.schedule, random_);
    // What is worse by x is taken once in e^(x / temperature) times: drawn beforehand, so that what is not taken need
    // not be looked at to the end.
    const double left = 1.0 - static_cast<double>(step) / static_cast<double>(steps);
    const double temperature = first_temperature * best.score * left;
    const double limit = at.score - temperature * model::portable_log(1.0 - random_.fraction());
    next.score = guessed_score(next.schedule, limit);
    if (next.score > limit) continue;
    std::swap(at, next);
    if (at.score < best.score) best = at;
  }
  best.unbounded = best.score;
  work_ += work_of_guesses(steps, app_.graph.subchains().size());
  return best;
}

// --- By trials ---

void ScheduleSearch::set_horizon(const Schedule& schedule) {
  const trial::Figures figures = run_trial(schedule, {.horizon = kShortestHorizon});
  double slowest = 0.0;
  for (const trial::TermFigures& term : figures.terms) slowest = std::max(slowest, term.mean_ms);
  horizon_ = std::clamp(to_nanos(Millis{kTermsATrial * slowest}), kShortestHorizon, kLongestHorizon);
}

trial::Figures ScheduleSearch::try_out(const Schedule& schedule, trial::Options options, Nanos at_least) {
  if (horizon_ == Nanos{0}) set_horizon(schedule);
  options.horizon = std::max(horizon_, at_least);
  options.p95 = true;
  return run_trial(schedule, options);
}

trial::Figures ScheduleSearch::run_trial(const Schedule& schedule, trial::Options options) {
  options.overheads = costs_->machine;
  trial::Figures figures = costs_->trial.run(schedule, options);
  work_ += work_of_trial(figures);
  return figures;
}

double ScheduleSearch::bounded(const Candidate& candidate, double score) {
  return scoring_.bounded(costs_->surrogate, candidate.schedule, candidate.relax, score);
}

double ScheduleSearch::glance(const Candidate& candidate) {
  if (horizon_ == Nanos{0}) set_horizon(candidate.schedule);
  const trial::Figures figures =
      run_trial(candidate.schedule, {.horizon = horizon_ / kGlance, .warm_up = horizon_ / (2 * kGlance), .p95 = true});
  return bounded(candidate, scoring_.at_a_glance(candidate.schedule, figures));
}

double ScheduleSearch::try_first(Candidate& candidate) {
  const trial::Figures figures = try_out(candidate.schedule, {.before_ticks = kBeforeTicks});
  const CoreUse used = scoring_.use(candidate.schedule, figures);
  candidate.tried = false;
  candidate.unbounded = scoring_.unbounded(candidate.schedule, figures, used);
  candidate.first_score = candidate.score = bounded(candidate, candidate.unbounded);
  candidate.factors.clear();
  if (fixed(candidate)) return used.fullest;
  const double found_fullest = used.fullest * (1.0 - setting_.slack + kLoadTolerance) / (1.0 - setting_.slack);
  const double guessed_fullest = costs_->surrogate.fullest();
  candidate.load_factor =
      guessed_fullest > 0.0 ? std::clamp(found_fullest / guessed_fullest, 1.0 / kMaxLoadFactor, kMaxLoadFactor) : 1.0;
  const std::vector<double>& guessed = costs_->surrogate.terms();
  for (std::size_t term = 0; term < figures.terms.size() && term < guessed.size(); ++term) {
    candidate.factors.push_back(guessed[term] > 0.0 ? scoring_.of_term(figures, term) / guessed[term] : 1.0);
  }
  return used.fullest;
}

double ScheduleSearch::try_again(Candidate& candidate) {
  trial::Options options{.first_draw = kSecondDraw, .since = kSecondTime, .before_ticks = kBeforeTicks};
  if (!phases_.empty()) {
    options.since = newest_tick(phases_) - TimePoint{};
    options.clocks = earlier_by(options.since, phases_);
  }
  const trial::Figures figures = try_out(candidate.schedule, options);
  const CoreUse used = scoring_.use(candidate.schedule, figures);
  const double second = scoring_.unbounded(candidate.schedule, figures, used);
  candidate.unbounded = (candidate.unbounded + second) / 2.0;
  candidate.score = bounded(candidate, candidate.unbounded);
  candidate.tried = true;
  return used.fullest;
}

// A little more load than there is makes a good schedule worth nothing; a little slower it is as good. It is slowed by
// what it takes and little more, since that much is lost. Exact rates stay as they are, and a core is never seen to be
// more than full, so this may not be enough.
void ScheduleSearch::try_whole(Candidate& candidate) {
  double more = candidate.given ? kKnownSlowerByMore : kSlowerByMore;
  for (int slowings = 0;; ++slowings, more *= 2.0) {
    double fullest_core = try_first(candidate);
    if (fullest_core <= 1.0) fullest_core = try_again(candidate);
    if (fullest_core <= 1.0) return;
    Schedule slower = slowed(candidate.schedule, fullest_core + more);
    if (fixed(candidate) || slowings == kMaxSlowings || slower == candidate.schedule) {
      if (!candidate.tried) try_again(candidate);
      return;
    }
    candidate.schedule = std::move(slower);
    candidate.glance = 0.0;
  }
}

// Beside one that was tried.
bool ScheduleSearch::is_hopeless(const Candidate& candidate) const {
  return std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& each) {
    return each.tried && each.score < scoring_.overload() && each.glance > 0.0 &&
           candidate.glance > each.glance * kHopeless;
  });
}

bool ScheduleSearch::has_untried() const {
  return std::any_of(candidates_.begin(), candidates_.end(), [](const Candidate& each) { return !each.tried; });
}

void ScheduleSearch::improve(Nanos work) {
  const Nanos before = work_;
  do {
    step();
  } while (work_ - before < work);
}

void ScheduleSearch::step() {
  const auto untried =
      std::find_if(candidates_.begin(), candidates_.end(), [](const Candidate& each) { return !each.tried; });
  if (untried != candidates_.end()) {
    if (!fixed(*untried)) {
      untried->glance = glance(*untried);
      if (is_hopeless(*untried)) {
        candidates_.erase(untried);
        return;
      }
    }
    try_whole(*untried);
    return std::stable_sort(candidates_.begin(), candidates_.end(), better);
  }
  ++steps_in_vain_;
  const std::size_t index = random_.once_in(2) ? 0 : random_.below(candidates_.size());
  Candidate& parent = candidates_[index];
  if (fixed(parent)) return replace_by_new(parent);
  // Each way of changing has as much of the work as the other.
  const Nanos before = work_;
  const bool by_formulas = work_by_formulas_ <= work_by_chance_;
  Candidate child = by_formulas ? changed_by_formulas(parent) : changed_by_chance(parent);
  ++parent.in_vain;
  if (child.schedule != parent.schedule) {
    if (parent.glance == 0.0) parent.glance = glance(parent);
    child.glance = glance(child);
  }
  if (child.glance > 0.0 && child.glance < parent.glance * kHopeless) {
    try_first(child);
    if (child.first_score < parent.first_score * kNearlyAsGood) try_again(child);
  }
  (by_formulas ? work_by_formulas_ : work_by_chance_) += work_ - before;
  if (child.tried && child.score < parent.score) {
    if (index == 0) steps_in_vain_ = 0;
    parent = std::move(child);
    return std::stable_sort(candidates_.begin(), candidates_.end(), better);
  }
  if (index > 0 && parent.in_vain > kGiveUpAfter) replace_by_new(parent);
}

ScheduleSearch::Candidate ScheduleSearch::changed_by_formulas(const Candidate& candidate) {
  costs_->surrogate.correct(candidate.factors, candidate.load_factor);
  return anneal(candidate.schedule, kStepsNearby, kTemperatureNearby);
}

ScheduleSearch::Candidate ScheduleSearch::changed_by_chance(const Candidate& candidate) {
  costs_->surrogate.correct(candidate.factors, candidate.load_factor);
  Candidate child{.schedule = candidate.schedule};
  const double before = guessed_score(child.schedule);
  std::size_t draws = 0;
  do {
    child.schedule = candidate.schedule;
    moves_->change(child.schedule, random_);
  } while (guessed_score(child.schedule, before * kPromising) > before * kPromising && ++draws < kRedraws);
  work_ += work_of_guesses(draws, app_.graph.subchains().size());
  return child;
}

// Those that are not to be changed stay beside it.
void ScheduleSearch::replace_by_new(Candidate& candidate) {
  costs_->surrogate.correct({});
  Schedule schedule = beginning(false);
  arrange(schedule, random_.below(kSortsOfBeginnings), true);
  Candidate fresh = anneal(std::move(schedule), kMinStepsABeginning, kTemperature);
  try_whole(fresh);
  if (fixed(candidate)) return keep(std::move(fresh));
  if (fresh.score < candidates_.front().score) steps_in_vain_ = 0;
  candidate = std::move(fresh);
  std::stable_sort(candidates_.begin(), candidates_.end(), better);
}

// --- What was found ---

// The candidate that is found worse keeps the score that it is found to have, so the loop ends at the latest when all
// were tried. How full cores are is not asked again: the usual trials have seen to that, with room for luck.
void ScheduleSearch::confirm(Nanos horizon) {
  while (has_untried()) step();
  for (;;) {
    Candidate& best = candidates_.front();
    const Expected longer = expected(best.schedule, horizon);
    CoreUse used = scoring_.use(best.schedule, longer.figures);
    used.overload = 0.0;
    const double found = scoring_.unbounded(best.schedule, longer.figures, used);
    if (found <= best.unbounded * kConfirmed) return;
    best.unbounded = found;
    best.score = bounded(best, found);
    std::stable_sort(candidates_.begin(), candidates_.end(), better);
  }
}

std::vector<Found> ScheduleSearch::best() const {
  std::vector<Found> found;
  for (const Candidate& candidate : candidates_) {
    found.push_back({candidate.schedule, candidate.unbounded, candidate.tried, candidate.relax});
  }
  return found;
}

Found ScheduleSearch::tried(const Schedule& schedule, std::optional<double> relax) {
  for (const Candidate& each : candidates_) {
    if (each.tried && each.schedule == schedule) return {schedule, each.unbounded, true, relax};
  }
  Candidate candidate{.schedule = schedule, .relax = relax};
  try_whole(candidate);
  return {candidate.schedule, candidate.unbounded, true, relax};
}

Expected ScheduleSearch::expected(const Schedule& schedule, Nanos at_least) {
  trial::Figures figures = try_out(schedule, {.first_draw = kLastDraw, .since = kLastTime}, at_least);
  return {std::move(figures), std::max(horizon_, at_least)};
}

}  // namespace ctn::planner
