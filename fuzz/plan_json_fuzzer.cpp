// Any bytes as a plan: a plan that can be written, read back and checked, or errors that say what is wrong.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "plan/json.h"
#include "plan/testing/sample_plan.h"
#include "plan/validate.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void require_reasons(const ctn::Error& error) {
  for (const ctn::Problem& problem : error.problems()) require(!problem.what.empty() && !problem.hint.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ctn::plan;
  static const ctn::graph::App app = sample_app();
  static const ctn::model::CostTable costs = sample_costs(app);
  const ctn::Result<Plan> plan = from_json({reinterpret_cast<const char*>(data), size}, app, "fuzz.json");
  if (!plan) {
    require_reasons(plan.error());
    return 0;
  }
  const ctn::Result<Plan> again = from_json(to_json(*plan, app), app, "fuzz.json");
  require(again.ok() && *again == *plan);
  const ctn::Status valid = validate(*plan, app, costs, kSampleCores);
  if (!valid) require_reasons(valid.error());
  return 0;
}
