#include "api/known_costs.h"

#include "config/cost_file.h"
#include "policy/costs_of_record.h"
#include "record/reader.h"

namespace ctn::api {

Result<KnownCosts> known_costs(const std::string& file, const graph::App& app) {
  if (!record::looks_like_record(file)) {
    const Result<model::Workload> work = config::load_workload(file, app);
    if (!work) return work.error();
    return KnownCosts{work->costs(app.graph), trial::Samples(app, *work, Nanos{0}, 1)};
  }
  const Result<record::Reader> record = record::Reader::open(file);
  if (!record) return record.error();
  const Result<policy::MeasuredCosts> measured = policy::costs_of_record(*record, app);
  if (!measured) return measured.error();
  model::CostTable costs = measured->costs(Millis{0});
  trial::Samples samples(app, measured->runs(), costs);
  return KnownCosts{std::move(costs), std::move(samples)};
}

}  // namespace ctn::api
