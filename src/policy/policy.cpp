#include "policy/policy.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "config/quantity.h"
#include "policy/compared.h"
#include "policy/hand_set.h"
#include "policy/planned.h"

namespace ctn::policy {
namespace {

using Made = std::shared_ptr<const Policy>;

}  // namespace

Result<std::optional<Decision>> Policy::decide_anew(const Situation& situation, const Decision& /*in_force*/,
                                                    double /*to_beat*/) const {
  Result<Decision> decision = decide(situation);
  if (!decision) return decision.error();
  return std::optional(std::move(*decision));
}

Result<Made> make_policy(std::string_view text) {
  if (text == "catan") return Made(std::make_shared<CatanPolicy>());
  if (text == "default") return Made(std::make_shared<DefaultPolicy>());
  if (text == "fifo") return Made(std::make_shared<FifoPolicy>());
  if (Made compared = make_compared_policy(text)) return compared;
  constexpr std::string_view kStatic = "static:";
  if (text.starts_with(kStatic) && text.size() > kStatic.size()) {
    return Made(std::make_shared<StaticPolicy>(std::string(text.substr(kStatic.size()))));
  }
  constexpr std::string_view kRate = "rate:";
  if (text.starts_with(kRate)) {
    std::string number(text.substr(kRate.size()));
    if (!number.ends_with("Hz")) number += "Hz";
    if (const Result<Rate> rate = config::parse_rate(number)) {
      return Made(std::make_shared<RatePolicy>(*rate, std::string(text)));
    }
  }
  return Error::caller(
      fmt::format("'{}' is no scheduler", text),
      "write catan, default, fifo, static:PLAN.json, a source rate as in rate:12.5, or picas, deadline, davare "
      "or verucchi, with compute times as in picas:COSTS.yaml");
}

}  // namespace ctn::policy
