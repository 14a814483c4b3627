// A picture of a world, for people: walls, movers and their paths, the robot, its way and its newest scan; what has
// been seen, if the robot explores; and what the robot believes: obstacles of its map, and where it wants to go.
//
// To take a shot costs little and needs the world; to draw it takes tens of milliseconds and does not, so another
// thread can do it.
//
// Thread safety: take_shot() as World; the rest from any thread.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "catan/result.h"
#include "geometry.h"
#include "mover.h"
#include "sensors.h"
#include "world.h"
#include "world_file.h"

namespace ctn::navigation::world {

// What a picture shows of an instant, apart from the file.
struct Shot {
  std::chrono::nanoseconds at{};
  Pose robot;
  Scan scan;
  Pose scanned_from;
  std::vector<Point> way;
  std::vector<Point> contacts;
  std::vector<Point> unseen;  // centres of cells of kSeenCell
};

// What the robot takes to be so, in the world's frame.
struct Belief {
  std::vector<Point> path;
  std::vector<Point> obstacles;  // centres of cells
  double cell = 0.0;             // their side
};

Shot take_shot(World& world);

// Writes PNG, or another format that the ending of the name says. Errors: kEnvironment, the picture cannot be written;
// kCaller, there is no such format.
Status write_picture(const WorldFile& file, const std::vector<Mover>& movers, const Shot& shot, const Belief& belief,
                     const std::string& path);
Status write_picture(World& world, const std::string& path);

}  // namespace ctn::navigation::world
