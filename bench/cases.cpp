#include "cases.h"

#include <utility>

#include "config/app_file.h"
#include "config/cost_file.h"
#include "value_of.h"

namespace ctn::bench {
std::string frozen_files(const std::string& name) { return CATAN_SOURCE_DIR "/bench/cases/" + name; }

Case frozen_case(const std::string& name) {
  graph::App app = value_of(config::load_app(frozen_files(name) + ".yaml"));
  model::Workload work = value_of(config::load_workload(frozen_files(name) + ".load.yaml", app));
  return {name, std::move(app), std::move(work)};
}

}  // namespace ctn::bench
