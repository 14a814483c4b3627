// Apps for tests.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "config/app_file.h"
#include "graph/app.h"

namespace ctn {

inline graph::App parse(const std::string& text) {
  Result<graph::App> app = config::parse_app(text, "test.yaml");
  if (!app) {
    ADD_FAILURE() << app.error().message();
    std::abort();
  }
  return std::move(*app);
}

// One subchain of four nodes, as the face tracker's.
inline graph::App tracker_app() {
  return parse(R"(
catan: 1
app: tracker
nodes: { camera: { fallback_rate: 30Hz }, detect: {}, plan: {}, motor: {} }
edges: [ camera -> detect -> plan -> motor ]
subchains: { track: [camera, detect, plan, motor] }
objective: [ { response_time: [camera, detect, plan, motor], weight: 1 } ]
)");
}

}  // namespace ctn
