#include "policy/stale_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::policy {
namespace {

std::string ms(Nanos duration) { return fmt::format("{:.4g} ms", to_millis(duration).count()); }

}  // namespace

StaleInputs::StaleInputs(const graph::Graph& graph) : graph_(graph), inputs_(graph.nodes().size()) {
  for (const graph::Edge& edge : graph.edges()) {
    if (!edge.age_limit) continue;
    const std::vector<NodeId>& predecessors = graph.node(edge.to).predecessors;
    const auto index = std::find(predecessors.begin(), predecessors.end(), edge.from) - predecessors.begin();
    inputs_[edge.to.index()].push_back({static_cast<std::size_t>(index), edge, std::nullopt});
  }
}

std::vector<record::Notice> StaleInputs::ran(const record::Run& run) {
  std::vector<record::Notice> notices;
  for (Input& input : inputs_[run.node.index()]) {
    if (auto notice = look(input, run)) notices.push_back(std::move(*notice));
  }
  return notices;
}

std::optional<record::Notice> StaleInputs::look(Input& input, const record::Run& run) const {
  if (input.index >= run.ages.size() || run.ages[input.index] == record::kNoAge) return std::nullopt;
  const Nanos age = run.ages[input.index];
  const graph::AgeLimit& limit = *input.edge.age_limit;
  const std::string& from = graph_.node(input.edge.from).name;
  const std::string& to = graph_.node(input.edge.to).name;
  if (age > limit.max_age) {
    const bool begins = !input.episode;
    if (begins) input.episode = Episode{};
    ++input.episode->runs;
    input.episode->oldest = std::max(input.episode->oldest, age);
    input.episode->last = run.begin;
    if (!begins) return std::nullopt;
    return record::Notice{
        run.end, "stale-input",
        fmt::format("what {} takes from {} is {} old, its max_age is {}{}", to, from, ms(age), ms(limit.max_age),
                    limit.on_stale == graph::OnStale::kSkip ? ": such runs give no output" : "")};
  }
  if (!input.episode || run.begin - input.episode->last < kCalm) return std::nullopt;
  const Episode over = *std::exchange(input.episode, std::nullopt);
  return record::Notice{
      run.end, "stale-input",
      fmt::format("what {} takes from {} is no older than its max_age of {} again; {} run{} had older "
                  "data, the oldest of {}",
                  to, from, ms(limit.max_age), over.runs, over.runs == 1 ? "" : "s", ms(over.oldest))};
}

}  // namespace ctn::policy
