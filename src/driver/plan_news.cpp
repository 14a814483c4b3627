#include "driver/plan_news.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "plan/above_promise.h"
#include "plan/limits.h"

namespace ctn::driver {
namespace {

// By how much a bound has to be missed more, or less, than was told to be told again.
constexpr double kMuch = 0.1;
constexpr std::size_t kNamed = 8;  // in one notice, at most

using Relaxed = std::map<std::string, double>;

Relaxed relaxed_by(const plan::Plan& plan) {
  Relaxed factors;
  for (const plan::RelaxedBound& bound : plan.relaxed) factors[bound.key] = bound.planned / bound.asked;
  return factors;
}

double factor_of(const Relaxed& factors, const std::string& key) {
  const auto found = factors.find(key);
  return found == factors.end() ? 1.0 : found->second;
}

bool much_changed(const Relaxed& told, const Relaxed& now) {
  if (told.empty() != now.empty()) return true;
  const auto differs = [](const Relaxed& from, const Relaxed& to) {
    return std::any_of(from.begin(), from.end(), [&](const auto& bound) {
      const double other = factor_of(to, bound.first);
      return std::abs(other - bound.second) > kMuch * std::max(other, bound.second);
    });
  };
  return differs(told, now) || differs(now, told);
}

// A rate is asked for as a rate, so it is told as one.
std::string text_of(const plan::RelaxedBound& bound) {
  if (bound.key.ends_with(".min_rate")) {
    return fmt::format("{}: {:.4g} Hz, not {:.4g} Hz", bound.key, 1000.0 / bound.planned.count(),
                       1000.0 / bound.asked.count());
  }
  return fmt::format("{}: {:.4g} ms, not {:.4g} ms", bound.key, bound.planned.count(), bound.asked.count());
}

std::string joined(const std::vector<std::string>& texts) {
  const auto shown = static_cast<std::ptrdiff_t>(std::min(texts.size(), kNamed));
  std::string text = fmt::format("{}", fmt::join(texts.begin(), texts.begin() + shown, ", "));
  if (texts.size() > kNamed) text += fmt::format(" and {} more", texts.size() - kNamed);
  return text;
}

}  // namespace

std::vector<PlanNews::Notice> PlanNews::in_force(const plan::Plan& plan) {
  std::vector<Notice> notices;
  if (rests_on_nothing(plan)) {
    tell_lower_guess(plan, notices);
    if (plan::relaxes_exact_rates(plan, app_)) tell_relaxed(plan, notices);
    return notices;
  }
  tell_assumed(plan, notices);
  tell_relaxed(plan, notices);
  tell_above_promise(plan, notices);
  return notices;
}

bool PlanNews::rests_on_nothing(const plan::Plan& plan) const {
  const auto scheduled = std::count_if(app_.graph.nodes().begin(), app_.graph.nodes().end(),
                                       [](const graph::Node& node) { return node.subchain.has_value(); });
  return plan.assumed.size() == static_cast<std::size_t>(scheduled);
}

void PlanNews::tell_relaxed(const plan::Plan& plan, std::vector<Notice>& notices) {
  Relaxed now = relaxed_by(plan);
  if (!much_changed(relaxed_, now)) return;
  relaxed_ = std::move(now);
  if (relaxed_.empty()) {
    notices.push_back({"relaxed", "all bounds hold again"});
    return;
  }
  std::vector<std::string> texts;
  for (const plan::RelaxedBound& bound : plan.relaxed) texts.push_back(text_of(bound));
  notices.push_back(
      {"relaxed",
       fmt::format("not all bounds can be kept; they are relaxed by a factor of {:.3g}{}: {}", plan.relax_factor,
                   plan.assumed.empty() ? "" : " (some compute times are assumed)", joined(texts))});
}

// Of those that come and go each is told once, until there is none.
void PlanNews::tell_above_promise(const plan::Plan& plan, std::vector<Notice>& notices) {
  const std::vector<std::size_t> now = plan::chains_above_promise(plan);
  if (now.empty()) {
    if (!above_promise_.empty()) {
      notices.push_back({"above-promise", "no chain is expected to take longer than it is promised any more"});
    }
    above_promise_.clear();
    return;
  }
  std::vector<std::string> texts;
  bool more = false;
  for (const std::size_t chain : now) {
    texts.push_back(fmt::format("{}: {:.4g} ms, not {:.4g} ms", app_.graph.path_name(plan.chains[chain].path),
                                plan.expected->chains[chain].response.count(), plan.chains[chain].response.count()));
    if (std::find(above_promise_.begin(), above_promise_.end(), chain) != above_promise_.end()) continue;
    above_promise_.push_back(chain);
    more = true;
  }
  if (!more) return;
  notices.push_back({"above-promise", fmt::format("expected to take longer than promised: {} (it may be that {})",
                                                  joined(texts), plan::why_above_promise(plan, app_))});
}

void PlanNews::tell_lower_guess(const plan::Plan& plan, std::vector<Notice>& notices) {
  const double guess = to_millis(app_.scheduler.bootstrap_cost).count();
  const double cost = plan.assumed.empty() ? guess : plan.assumed.front().cost.count();
  if (cost >= guess || std::exchange(lower_guess_told_, true)) return;
  notices.push_back({"assumed-costs", fmt::format("exact rates could not be met if nodes cost {:.4g} ms "
                                                  "(bootstrap_cost): until they have run they are taken to cost "
                                                  "{:.4g} ms",
                                                  guess, cost)});
}

void PlanNews::tell_assumed(const plan::Plan& plan, std::vector<Notice>& notices) {
  const auto is_in = [](const std::vector<plan::AssumedCost>& list, NodeId node) {
    return std::any_of(list.begin(), list.end(), [&](const plan::AssumedCost& cost) { return cost.node == node; });
  };
  std::vector<plan::AssumedCost> known;  // now
  for (const plan::AssumedCost& cost : assumed_) {
    if (!is_in(plan.assumed, cost.node)) known.push_back(cost);
  }
  const bool more = std::any_of(plan.assumed.begin(), plan.assumed.end(),
                                [&](const plan::AssumedCost& cost) { return !is_in(assumed_, cost.node); });
  const bool guess_over = std::exchange(lower_guess_told_, false);
  assumed_ = plan.assumed;
  if (!known.empty()) {
    std::string text = fmt::format("compute times are known now of: {}", names(known, false));
    if (!assumed_.empty()) text += fmt::format("; still assumed: {}", names(assumed_, true));
    notices.push_back({"assumed-costs", std::move(text)});
  } else if (more) {
    notices.push_back({"assumed-costs", fmt::format("these nodes have not run, and are planned at compute times that "
                                                    "are assumed: {}",
                                                    names(assumed_, true))});
  } else if (guess_over && assumed_.empty()) {
    notices.push_back({"assumed-costs", "the compute times of all nodes are known now"});
  }
}

std::string PlanNews::names(const std::vector<plan::AssumedCost>& nodes, bool with_costs) const {
  std::vector<std::string> texts;
  for (const plan::AssumedCost& cost : nodes) {
    const std::string& name = app_.graph.node(cost.node).name;
    texts.push_back(with_costs ? fmt::format("{} ({:.4g} ms)", name, cost.cost.count()) : name);
  }
  return joined(texts);
}

}  // namespace ctn::driver
