#include "web/timeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

namespace ctn::web {

Timeline::Timeline(const graph::App& app, TimePoint started) : started_(started) {
  for (const graph::Subchain& subchain : app.graph.subchains()) names_.push_back(subchain.name);
  for (const graph::Node& node : app.graph.nodes()) {
    lane_of_.push_back(node.subchain ? node.subchain->index() : names_.size());
    if (!node.subchain && !node.external) names_.push_back(node.name);
  }
}

void Timeline::add(const record::Run& run) {
  if (run.node.index() >= lane_of_.size() || run.end <= run.begin || run.begin < started_) return;
  const std::size_t lane = lane_of_[run.node.index()];
  const int cpu = std::max(run.on_cpu, -1);
  if (lane >= names_.size() || (!of_.contains(cpu) && of_.size() >= kMaxCpus)) return;
  Busy& busy = of_[cpu].try_emplace(lane).first->second;
  const std::int64_t last = step_of(run.end - Nanos{1});
  const std::int64_t first = std::max(step_of(run.begin), last - static_cast<std::int64_t>(kSteps) + 1);
  const double share =
      std::min(1.0, static_cast<double>(run.cpu.count()) / static_cast<double>((run.end - run.begin).count()));
  for (std::int64_t step = first; step <= last; ++step) {
    const TimePoint begin = std::max(run.begin, started_ + step * kStep);
    const TimePoint end = std::min(run.end, started_ + (step + 1) * kStep);
    if (end <= begin) continue;
    const std::size_t place = static_cast<std::size_t>(step) % kSteps;
    if (busy.step[place] > step) continue;  // of the round before: the place is for a newer step already
    if (busy.step[place] < step) busy.share[place] = 0.0F;
    busy.step[place] = step;
    busy.share[place] +=
        static_cast<float>(share * static_cast<double>((end - begin).count()) / static_cast<double>(kStep.count()));
  }
}

std::string Timeline::json(TimePoint now) const {
  const std::int64_t until = std::max<std::int64_t>(step_of(now), 0);  // only steps that are over are shown
  const std::int64_t from = std::max<std::int64_t>(until - static_cast<std::int64_t>(kSteps), 0);
  nlohmann::ordered_json json{{"step_ms", to_millis(kStep).count()},
                              {"until_s", in_seconds(until * kStep)},
                              {"lanes", names_},
                              {"cpus", nlohmann::ordered_json::array()}};
  for (const auto& [cpu, lanes] : of_) {
    nlohmann::ordered_json row{{"cpu", cpu < 0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(cpu)},
                               {"busy", nlohmann::ordered_json::array()}};
    for (const auto& [lane, busy] : lanes) {
      std::vector<int> permille;
      bool any = false;
      for (std::int64_t step = from; step < until; ++step) {
        const std::size_t place = static_cast<std::size_t>(step) % kSteps;
        const float share = busy.step[place] == step ? busy.share[place] : 0.0F;
        permille.push_back(static_cast<int>(std::lround(1000.0F * std::min(share, 1.0F))));
        any = any || permille.back() > 0;
      }
      if (any) row["busy"].push_back({{"lane", lane}, {"permille", std::move(permille)}});
    }
    json["cpus"].push_back(std::move(row));
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace ctn::web
