// For tests of what is shown of a running app: the events of a made-up run. The app and its plan:
// plan/testing/sample_plan.h.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "base/testing/times.h"
#include "os/cpu_set.h"
#include "plan/json.h"
#include "plan/testing/sample_plan.h"
#include "view/live_view.h"

namespace ctn::view {

inline record::Header header_of_test() {
  record::Header header;
  header.scheduler = "catan";
  header.cpus = os::CpuSet{2, 3, 5};
  header.real_time = true;
  header.started = at_ms(0);
  return header;
}

class LiveViewTest : public ::testing::Test {
 protected:
  LiveViewTest() { view.add(record::Trigger{plan::kFast, 1, at_ms(9), at_ms(10)}); }

  NodeId id(const std::string& name) const { return *app.graph.find_node(name); }
  void plan_comes(int at_millis, const plan::Plan& next, const std::string& reason = "measured") {
    view.add(record::PlanChange{at_ms(at_millis), reason, plan::to_json(next, app)});
  }
  // A run of `fast`: scan takes 2 ms, steer the rest.
  void fast(std::uint64_t number, int begin, int took = 6) {
    view.add(record::Run{id("scan"), number, at_ms(begin), at_ms(begin + 2), ms(2), 0, true, {}, 2});
    view.add(record::Run{id("steer"),
                         number,
                         at_ms(begin + 2),
                         at_ms(begin + took),
                         ms(took - 2),
                         0,
                         true,
                         {{id("scan"), number, number}},
                         2});
  }
  Picture picture(int now) const { return view.picture(at_ms(now), {.seen_alive = at_ms(now)}); }

  graph::App app = plan::sample_app();
  plan::Plan plan = plan::sample_plan(app, plan::sample_costs(app));
  LiveView view{app, header_of_test()};
};

}  // namespace ctn::view
