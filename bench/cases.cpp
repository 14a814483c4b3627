#include "cases.h"

#include <stdexcept>
#include <utility>

#include "config/app_file.h"
#include "config/cost_file.h"

namespace ctn::bench {
namespace {

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

}  // namespace

std::string frozen_files(const std::string& name) { return CATAN_SOURCE_DIR "/bench/cases/" + name; }

Case frozen_case(const std::string& name) {
  graph::App app = value_of(config::load_app(frozen_files(name) + ".yaml"));
  model::Workload work = value_of(config::load_workload(frozen_files(name) + ".load.yaml", app));
  return {name, std::move(app), std::move(work)};
}

}  // namespace ctn::bench
