#include "runtime/policy.h"

#include <fmt/format.h>

#include <cassert>
#include <optional>

#include "config/quantity.h"

namespace ctn::runtime {

Result<Policy> parse_policy(std::string_view text) {
  if (text == "catan") return Policy{Policy::Kind::kCatan, std::nullopt, {}, std::string(text)};
  if (text == "default") return Policy{Policy::Kind::kDefault, std::nullopt, {}, std::string(text)};
  if (text == "fifo") return Policy{Policy::Kind::kFifo, std::nullopt, {}, std::string(text)};
  constexpr std::string_view kStatic = "static:";
  if (text.starts_with(kStatic) && text.size() > kStatic.size()) {
    return Policy{Policy::Kind::kStatic, std::nullopt, std::string(text.substr(kStatic.size())), std::string(text)};
  }
  constexpr std::string_view kPrefix = "rate:";
  if (text.starts_with(kPrefix)) {
    std::string number(text.substr(kPrefix.size()));
    if (!number.ends_with("Hz")) number += "Hz";
    Result<Rate> rate = config::parse_rate(number);
    if (rate) return Policy{Policy::Kind::kRate, *rate, {}, std::string(text)};
  }
  return Error::caller(fmt::format("'{}' is no scheduler", text),
                       "write catan, default, fifo, static:PLAN.json, or a source rate as in rate:12.5");
}

Result<std::vector<Rate>> hand_set_rates(const Policy& policy, const graph::App& app) {
  assert(!policy.follows_plan());
  std::vector<Rate> rates;
  std::vector<Problem> problems;
  for (const graph::Subchain& subchain : app.graph.subchains()) {
    const graph::Node& head = app.graph.node(subchain.head());
    if (policy.kind == Policy::Kind::kRate && head.predecessors.empty()) {
      rates.push_back(*policy.rate);
    } else if (head.fallback_rate) {
      rates.push_back(*head.fallback_rate);
    } else {
      problems.push_back(
          {{},
           fmt::format("nodes.{}.fallback_rate", head.name),
           fmt::format("is not set, and scheduler '{}' needs a rate for subchain {}", policy.name, subchain.name),
           fmt::format("write {}: {{ fallback_rate: 10Hz }}", head.name)});
    }
  }
  if (!problems.empty()) return Error(ErrorKind::kCaller, std::move(problems));
  return rates;
}

}  // namespace ctn::runtime
