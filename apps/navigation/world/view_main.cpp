// navigation_view: checks a world's file, or makes a crowd, and draws the world with the robot in it.
#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <string>

#include <CLI/CLI.hpp>

#include "crowd.h"
#include "picture.h"
#include "world.h"
#include "world_file.h"

namespace {

using namespace ctn::navigation::world;

int complain(const ctn::Error& error) {
  fmt::print(stderr, "{}\n", error.message());
  return error.kind() == ctn::ErrorKind::kCaller ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Checks a world's file, or makes a crowd, and draws the world (docs/navigation-worlds.md).");
  std::string file;
  std::string picture;
  std::string yaml;
  CrowdSpec crowd;
  double seconds = 0.0;
  double speed = 0.0;
  double turn_rate = 0.0;
  WorldOptions options;
  app.add_option("world", file, "File of a world; without one, a crowd is made");
  app.add_option("--crowd", crowd.seed, "Seed from which the crowd is made")->capture_default_str();
  app.add_option("--density", crowd.density, "Share of the ground that clutter of the crowd covers")
      ->check(CLI::Range(0.0, 0.3))
      ->capture_default_str();
  app.add_option("--movers", crowd.movers, "Number of movers in the crowd")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of noise, and of phases that the file leaves open")
      ->capture_default_str();
  app.add_option("--seconds", seconds, "Time that passes before the world is drawn")->check(CLI::Range(0.0, 3600.0));
  app.add_option("--speed", speed, "Speed of the robot meanwhile, in m/s");
  app.add_option("--turn-rate", turn_rate, "Turn rate of the robot meanwhile, in rad/s");
  app.add_option("--picture", picture, "Draw the world into this file");
  app.add_option("--yaml", yaml, "Write the world to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  auto read = file.empty() ? ctn::Result<WorldFile>(make_crowd(crowd)) : read_world(file);
  if (!read) return complain(read.error());
  if (!yaml.empty() && !(std::ofstream(yaml) << to_yaml(*read))) {
    return complain(ctn::Error::environment(fmt::format("{} cannot be written", yaml), "name another file"));
  }
  World world(*read, options);
  world.command(std::chrono::nanoseconds(0), {speed, turn_rate});
  world.advance(std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9)));
  if (!picture.empty()) {
    if (ctn::Status drawn = write_picture(world, picture); !drawn) return complain(drawn.error());
  }
  const Score score = world.score();
  fmt::print("{}: {:.1f} m x {:.1f} m, {} pieces of wall, {} movers; {} contacts, {:.2f} m driven", read->name,
             read->bounds.width(), read->bounds.height(), read->walls.size(), read->movers.size(),
             score.contacts.size(), score.travelled);
  if (read->explore()) fmt::print(", {:.1f} % seen", score.explored * 100.0);
  fmt::print("\n");
  return 0;
}
