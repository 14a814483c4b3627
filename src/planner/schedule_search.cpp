#include "planner/schedule_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "model/portable_math.h"
#include "planner/moves.h"
#include "planner/surrogate.h"

namespace ctn::planner {
namespace {

using trial::Place;
using trial::Schedule;

constexpr double kOverload = 1e9;

constexpr std::size_t kBeginnings = 16;
constexpr std::size_t kImproved = 6;  // of them, in the first round
// At the start of the annealing, a step that makes the score worse by so much of it is taken once in e times.
constexpr double kTemperature = 0.03;
// A step that a short trial finds worse by no more is given a long one.
constexpr double kPromising = 1.01;

// A long trial is so many times as long as the slowest term, so that a mean means something.
constexpr double kTermsATrial = 30.0;
constexpr Nanos kShortestHorizon = std::chrono::seconds{8};
constexpr Nanos kLongestHorizon = std::chrono::seconds{120};

struct Candidate {
  Schedule schedule;
  double score = std::numeric_limits<double>::infinity();
  std::optional<double> relax{};  // where it is known; else by the surrogate
};

bool better(const Candidate& a, const Candidate& b) { return a.score < b.score; }

class Search {
 public:
  Search(const graph::App& app, const trial::Samples& samples, const model::CostTable& planned,
         const SearchRequest& request)
      : app_(app),
        request_(request),
        surrogate_(app, samples, planned, request.slack),
        trial_(app, samples),
        random_(request.seed),
        moves_(app, mean_costs(), all_cores()) {}

  std::vector<Found> run() {
    std::vector<Candidate> candidates = guess();
    for (const KnownSchedule& known : request_.known) candidates.push_back({known.schedule, 0.0, relax_of(known)});
    horizon_ = horizon_for(candidates.front().schedule);
    for (Candidate& candidate : candidates) candidate.score = try_out(candidate, horizon_ / 4);
    std::stable_sort(candidates.begin(), candidates.end(), better);
    improve(candidates);
    std::vector<Found> found;
    for (const Candidate& candidate : candidates) found.push_back(tried(candidate.schedule));
    for (const KnownSchedule& known : request_.known) found.push_back(tried(known.schedule));
    return found;
  }

 private:
  std::vector<double> mean_costs() const {
    std::vector<double> costs;
    for (std::size_t i = 0; i < app_.graph.subchains().size(); ++i) {
      costs.push_back(surrogate_.mean_cost(SubchainId(i), 0));
    }
    return costs;
  }
  std::vector<int> all_cores() const {
    std::vector<int> cores(static_cast<std::size_t>(request_.cores));
    std::iota(cores.begin(), cores.end(), 0);
    return cores;
  }

  // --- by the surrogate ---

  std::vector<Candidate> guess() {
    std::vector<Candidate> best;
    for (std::size_t number = 0; number < kBeginnings; ++number) {
      best.push_back(anneal(beginning(number == 0), request_.guesses / kBeginnings));
    }
    std::stable_sort(best.begin(), best.end(), better);
    return best;
  }

  // Cores evenly filled, or by chance; what weighs much and costs little above the rest; each core's time in the
  // proportions that are best where response times are periods (Lagrange).
  Schedule beginning(bool even) {
    const std::size_t count = app_.graph.subchains().size();
    std::vector<double> weight;
    for (std::size_t i = 0; i < count; ++i) {
      constexpr double kLeastWeight = 1e-4;
      weight.push_back(std::max(app_.weight_of(SubchainId(i)), kLeastWeight));
    }
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    const auto cost = [&](std::size_t i, int core) { return surrogate_.mean_cost(SubchainId(i), core); };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weight[a] * cost(a, 0) > weight[b] * cost(b, 0); });
    Schedule schedule{.cores = request_.cores, .subchains = std::vector<Place>(count), .frames = {}, .pipelines = {}};
    std::vector<double> demand(static_cast<std::size_t>(request_.cores), 0.0);
    for (const std::size_t i : order) {
      const std::size_t core =
          even ? static_cast<std::size_t>(std::min_element(demand.begin(), demand.end()) - demand.begin())
               : random_.below(demand.size());
      schedule.subchains[i].core = static_cast<int>(core);
      demand[core] += std::sqrt(weight[i] * cost(i, static_cast<int>(core)));
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weight[a] / cost(a, 0) > weight[b] / cost(b, 0); });
    for (std::size_t rank = 0; rank < count; ++rank) {
      schedule.subchains[order[rank]].priority = static_cast<int>(count - rank);
    }
    for (std::size_t i = 0; i < count; ++i) {
      Place& place = schedule.subchains[i];
      const double root = std::sqrt(cost(i, place.core) / weight[i]);
      const Millis period{root * demand[static_cast<std::size_t>(place.core)] / (1.0 - request_.slack)};
      place.period =
          moves_.exact(i) ? moves_.shortest_period(i) : std::max(to_nanos(period), moves_.shortest_period(i));
    }
    return schedule;
  }

  double guessed_score(const Schedule& schedule) {
    const std::optional<Estimate> estimate = surrogate_(schedule);
    if (!estimate) return 2.0 * kOverload;
    if (estimate->load > 1.0) return kOverload * estimate->load;
    if (estimate->exact_missed || !estimate->promised) return kOverload;
    return relaxed_score(estimate->objective, estimate->relax);
  }

  Candidate anneal(Schedule schedule, std::size_t steps) {
    Candidate at{std::move(schedule), 0.0, {}};
    at.score = guessed_score(at.schedule);
    Candidate best = at;
    Candidate next = at;
    for (std::size_t step = 0; step < steps; ++step) {
      next.schedule = at.schedule;
      moves_.change(next.schedule, random_);
      next.score = guessed_score(next.schedule);
      const double left = 1.0 - static_cast<double>(step) / static_cast<double>(steps);
      const double temperature = kTemperature * best.score * left;
      const double worse = (next.score - at.score) / temperature;
      constexpr double kNever = 30.0;
      if (worse > 0.0 && (worse > kNever || random_.fraction() >= model::portable_exp(-worse))) continue;
      std::swap(at, next);
      if (at.score < best.score) best = at;
    }
    return best;
  }

  // --- by trials ---

  Nanos horizon_for(const Schedule& schedule) {
    const trial::Figures figures = trial_.run(schedule, {.horizon = kShortestHorizon});
    double slowest = 0.0;
    for (const trial::TermFigures& term : figures.terms) slowest = std::max(slowest, term.mean_ms);
    return std::clamp(to_nanos(Millis{kTermsATrial * slowest}), kShortestHorizon, kLongestHorizon);
  }

  // Of frames and pipelines the surrogate knows nothing, or less.
  static std::optional<double> relax_of(const KnownSchedule& known) {
    const bool guessed = known.schedule.frames.empty() && known.schedule.pipelines.empty();
    return guessed ? std::nullopt : std::optional(known.relax);
  }

  // Without bounds.
  double unbounded_score(const trial::Figures& figures) const {
    double overload = 0.0;
    for (const double busy : figures.busy) overload += std::max(0.0, busy - (1.0 - request_.slack) - kLoadTolerance);
    double score = figures.objective;
    for (std::size_t term = 0; term < figures.terms.size(); ++term) {
      score += kTailWeight * app_.objective[term].weight * figures.terms[term].p95_ms;
    }
    return overload > 0.0 ? score + kOverload * overload : score;
  }

  double score_of(const Candidate& candidate, const trial::Figures& figures) {
    const double score = unbounded_score(figures);
    double relax = candidate.relax.value_or(1.0);
    if (!candidate.relax) {
      const std::optional<Estimate> estimate = surrogate_(candidate.schedule);
      if (!estimate || estimate->exact_missed || !estimate->promised) return 2.0 * kOverload;
      relax = estimate->relax;
    }
    return relaxed_score(score, relax);
  }

  double try_out(const Candidate& candidate, Nanos horizon) {
    return score_of(candidate, trial_.run(candidate.schedule, {.horizon = horizon, .p95 = true}));
  }

  // Step by step, so many.
  void improve(Candidate& candidate, std::size_t steps) {
    candidate.score = try_out(candidate, horizon_);
    if (!candidate.schedule.frames.empty()) return;
    double brief = try_out(candidate, horizon_ / 4);
    Candidate next = candidate;
    for (std::size_t step = 0; step < steps; ++step) {
      next.schedule = candidate.schedule;
      moves_.change(next.schedule, random_);
      if (guessed_score(next.schedule) >= kOverload) continue;
      const double next_brief = try_out(next, horizon_ / 4);
      if (next_brief > brief * kPromising) continue;
      next.score = try_out(next, horizon_);
      if (next.score >= candidate.score) continue;
      std::swap(candidate, next);
      brief = next_brief;
    }
  }

  // The best third of them and then a third of those go on, at the same effort a round.
  void improve(std::vector<Candidate>& candidates) {
    if (request_.trials == 0) return;
    candidates.resize(std::min(candidates.size(), kImproved));
    constexpr std::size_t kRounds = 3;
    auto going_on = static_cast<std::ptrdiff_t>(candidates.size());
    for (std::size_t round = 0; round < kRounds; ++round) {
      const std::size_t steps = request_.trials / kRounds / static_cast<std::size_t>(going_on);
      std::for_each_n(candidates.begin(), going_on, [&](Candidate& candidate) { improve(candidate, steps); });
      std::stable_sort(candidates.begin(), candidates.begin() + going_on, better);
      going_on = (going_on + 2) / 3;
    }
  }

  Found tried(const Schedule& schedule) {
    Found found{.schedule = schedule, .figures = {}, .horizon = horizon_, .score = 0.0};
    found.figures = trial_.run(schedule, {.horizon = horizon_, .p95 = true});
    found.score = unbounded_score(found.figures);
    return found;
  }

  const graph::App& app_;
  const SearchRequest& request_;
  Surrogate surrogate_;
  trial::Trial trial_;
  Random random_;
  Moves moves_;
  Nanos horizon_{0};
};

}  // namespace

std::vector<Found> search_schedule(const graph::App& app, const trial::Samples& samples,
                                   const model::CostTable& planned, const SearchRequest& request) {
  return Search(app, samples, planned, request).run();
}

}  // namespace ctn::planner
