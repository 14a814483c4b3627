#include "program/known_costs.h"

#include <algorithm>
#include <array>

#include "catan/planning.h"

namespace ctn::program {
namespace {

constexpr const char* kFullRun = "static-full-run";
constexpr const char* kFirstSeconds = "static-20s";
constexpr double kFirst = 20.0;

bool is_static(const std::string& scheduler) { return scheduler == kFullRun || scheduler == kFirstSeconds; }

}  // namespace

bool needs_costs(const std::string& scheduler) {
  constexpr std::array<const char*, 4> kMethods{"davare", "verucchi", "picas", "deadline"};
  return is_static(scheduler) || std::ranges::find(kMethods, scheduler) != kMethods.end();
}

double measuring_seconds(const std::string& scheduler, double seconds) {
  return scheduler == kFirstSeconds ? std::min(seconds, kFirst) : seconds;
}

Result<std::string> policy_by_costs(const std::string& scheduler, const std::string& costs, const std::string& app_file,
                                    bool one_core, const TemporaryFolder& folder) {
  if (!is_static(scheduler)) return scheduler + ":" + costs;
  const auto plan = make_plan(app_file, {.costs = costs, .cores = 1});
  if (!plan) return plan.error();
  const auto path = folder.write("plan.json", *plan);
  if (!path) return path.error();
  return (one_core ? "static:" : "rates-of:") + *path;
}

}  // namespace ctn::program
