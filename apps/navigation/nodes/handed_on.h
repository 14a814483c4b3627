// What LM and GL hand on beside what they compute: the newest odometry that they know. So whoever runs the nodes, a
// session or a framework's programs, gives the same to those that come next.
//
// Units: as the values. Thread safety: values, pure functions.
#pragma once

#include <memory>
#include <utility>

#include "global_localizer.h"
#include "local_mapper.h"
#include "sensors.h"

namespace ctn::navigation {

// From LM to LP.
struct Surroundings {
  std::shared_ptr<const LocalMap> map;
  Odometry odometry;  // where the robot is by now
};

// `wheels`: the newest odometry, null if there is none; what is older than the map's does not count.
inline Surroundings surroundings_of(LocalMap map, const Odometry* wheels) {
  auto shared = std::make_shared<const LocalMap>(std::move(map));
  const Odometry now = wheels != nullptr && wheels->stamp > shared->stamp ? *wheels : shared->odometry;
  return {std::move(shared), now};
}

// From GL to GM, GP and NC: where the robot was at GL's newest scan.
struct Fix {
  Localization localization;
  Odometry odometry;
};

}  // namespace ctn::navigation
