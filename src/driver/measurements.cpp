#include "driver/measurements.h"

#include "graph/change.h"

namespace ctn::driver {

void show_plan(const graph::App& app, const plan::Plan& plan, Snapshot& snapshot) {
  snapshot.relax_factor = plan.relax_factor;
  for (const plan::RelaxedBound& bound : plan.relaxed) {
    snapshot.relaxed.push_back({bound.key, bound.asked.count(), bound.planned.count()});
  }
  for (const plan::AssumedCost& assumed : plan.assumed) {
    snapshot.assumed.push_back({app.graph.node(assumed.node).name, assumed.cost.count()});
  }
}

void show_asked(const graph::App& asked, Snapshot& snapshot) {
  for (const graph::Term& term : asked.objective) {
    TermSnapshot& shown = snapshot.objective.emplace_back();
    shown.term = graph::term_name(asked, term);
    shown.weight = term.weight;
    if (term.max) shown.max_ms = to_millis(*term.max).count();
  }
  for (NodeSnapshot& node : snapshot.nodes) {
    const graph::Node& of_app = asked.graph.node(*asked.graph.find_node(node.name));
    if (of_app.min_rate) node.min_rate_hz = of_app.min_rate->hertz();
  }
}

}  // namespace ctn::driver
