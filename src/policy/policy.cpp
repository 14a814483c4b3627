#include "policy/policy.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "config/quantity.h"
#include "graph/cut.h"
#include "policy/hand_set.h"
#include "policy/paper.h"
#include "policy/planned.h"
#include "policy/search_policy.h"

namespace ctn::policy {
namespace {

using Made = std::shared_ptr<const Policy>;

}  // namespace

Result<std::optional<Decision>> Policy::decide_again(const Situation& situation, const Decision& /*in_force*/) const {
  Result<Decision> decision = decide(situation);
  if (!decision) return decision.error();
  return std::optional(std::move(*decision));
}

graph::App as_run_by(const Policy& policy, graph::App app) {
  return policy.cuts_subchains() ? graph::cut_at_fallback_rates(app) : std::move(app);
}

Error costs_missing(const Policy& policy) {
  return Error::caller(
      fmt::format("scheduler '{}' decides once, by compute times that are known before", policy.name()),
      fmt::format("say which: {}:COSTS.yaml", policy.name()));
}

Result<Made> make_policy(std::string_view text) {
  if (text == "catan" || text == "auto") return Made(std::make_shared<SearchPolicy>(std::string(text)));
  if (text == "paper") return Made(std::make_shared<PaperPolicy>());
  if (text == "default") return Made(std::make_shared<DefaultPolicy>());
  if (text == "fifo") return Made(std::make_shared<FifoPolicy>());
  constexpr std::string_view kRate = "rate:";
  if (text.starts_with(kRate)) {
    std::string number(text.substr(kRate.size()));
    if (!number.ends_with("Hz")) number += "Hz";
    if (const Result<Rate> rate = config::parse_rate(number)) {
      return Made(std::make_shared<RatePolicy>(*rate, std::string(text)));
    }
  }
  return Error::caller(fmt::format("'{}' is no scheduler", text),
                       "write catan, auto, paper, default, fifo, or a source rate as in rate:12.5");
}

}  // namespace ctn::policy
