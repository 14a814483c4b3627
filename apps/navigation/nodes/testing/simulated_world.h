// The case study's world as a plant.
//
// Thread safety: as World.
#pragma once

#include <chrono>
#include <cmath>

#include "nodes/testing/plant.h"
#include "world/world.h"

namespace ctn::navigation::testing {

class SimulatedWorld final : public Plant {
 public:
  SimulatedWorld(const world::WorldFile& file, const world::WorldOptions& options) : world_(file, options) {}

  Scan scan() override { return world_.scan_at(world_.now()); }
  Odometry odometry() override { return world_.odometry_at(world_.now()); }
  void advance(double seconds, const Velocity& wanted) override {
    world_.command(world_.now(), wanted);
    world_.advance(world_.now() + std::chrono::nanoseconds(std::llround(seconds * 1e9)));
  }
  std::chrono::nanoseconds now() const override { return world_.now(); }

  world::World& world() { return world_; }

 private:
  world::World world_;
};

}  // namespace ctn::navigation::testing
