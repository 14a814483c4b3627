#include "why/json.h"

#include <nlohmann/json.hpp>

#include "record/metrics_json.h"

namespace ctn::why {
namespace {

using Json = nlohmann::ordered_json;

double ms(Nanos duration) { return to_millis(duration).count(); }

class Writer {
 public:
  Writer(const graph::App& app, TimePoint started) : app_(app), started_(started) {}

  Json operator()(const Response& response) const {
    Json parts = Json::array();
    for (const Part& part : response.parts) {
      parts.push_back({{"part", to_string(part.kind)},
                       {"node", name(part.node)},
                       {"by", name(part.by)},
                       {"begin_ms", ms(part.begin - started_)},
                       {"length_ms", ms(part.length())}});
    }
    Json cause = nullptr;
    if (response.cause) {
      cause = {{"cause", to_string(response.cause->kind)},
               {"node", name(response.cause->node)},
               {"by", name(response.cause->by)},
               {"beyond_usual_ms", ms(response.cause->beyond_usual)}};
    }
    return {{"begin_ms", ms(response.begin - started_)},
            {"response_ms", ms(response.length())},
            {"source_run", response.source_run},
            {"late", response.late},
            {"cause", cause},
            {"parts", parts}};
  }
  Json operator()(const UsualPart& usual) const {
    return {{"part", to_string(usual.kind)}, {"node", name(usual.node)}, {"median_ms", ms(usual.median)}};
  }

 private:
  std::string name(NodeId node) const { return app_.graph.node(node).name; }
  Json name(std::optional<NodeId> node) const { return node ? Json(name(*node)) : Json(nullptr); }

  const graph::App& app_;
  TimePoint started_;
};

}  // namespace

std::string to_json(const Analysis& analysis, const graph::App& app, TimePoint started) {
  const Writer write(app, started);
  Json causes = Json::object();
  for (const auto& [cause, count] : causes_by_count(analysis)) causes[to_string(cause)] = count;
  Json usual = Json::array();
  for (const UsualPart& part : analysis.usual) usual.push_back(write(part));
  Json worst = Json::array();
  for (const Response& response : analysis.worst) worst.push_back(write(response));
  const Json document = {{"chain", app.graph.path_name(app.objective[analysis.term].path)},
                         {"term", analysis.term},
                         {"responses", analysis.responses},
                         {"response_ms", record::to_json(analysis.response_ms)},
                         {"late_over_ms", ms(analysis.late_over)},
                         {"late_over", analysis.bound ? "bound" : "p99"},
                         {"late", analysis.late},
                         {"causes", causes},
                         {"explained", analysis.explained},
                         {"usual", usual},
                         {"worst", worst}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ctn::why
