#include "world_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "grid.h"
#include "image_outline.h"
#include "program/text_file.h"
#include "scene.h"

namespace ctn::navigation::world {
namespace {

constexpr double kLengthMax = 1000.0;  // of a world: for longer ones single precision is too coarse to find contact
constexpr std::size_t kBytesMax = std::size_t{4} << 20U;
constexpr std::size_t kWallsMax = 200'000;
constexpr double kCoarse = 0.1;  // cells of the grid on which a path is looked for
const char* const kPage = "docs/navigation-worlds.md";

using Entries = std::map<std::string, YAML::Node>;

// Reads one file; goes on after a mistake, so that all mistakes are reported at once.
class WorldReader {
 public:
  WorldReader(std::string file, std::string folder) : file_(std::move(file)), folder_(std::move(folder)) {}

  Result<WorldFile> read(const YAML::Node& root) {
    read_all(root);
    if (problems_.empty()) check();
    if (problems_.empty()) return std::move(world_);
    std::ranges::stable_sort(problems_, {},
                             [](const Problem& problem) { return std::tie(problem.place.line, problem.place.column); });
    return Error(ErrorKind::kCaller, std::move(problems_));
  }

 private:
  Place place(const YAML::Node& node) const {
    const YAML::Mark mark = node.Mark();
    if (mark.is_null()) return {file_, 1, 1};
    return {file_, mark.line + 1, mark.column + 1};
  }
  void add(const Place& at, const std::string& key, std::string what, std::string hint) {
    problems_.push_back({at, key, std::move(what), std::move(hint)});
  }
  void add(const YAML::Node& node, const std::string& key, std::string what, std::string hint) {
    add(place(node), key, std::move(what), std::move(hint));
  }

  static std::string found(const YAML::Node& node) {
    if (node.IsMap()) return "a map";
    if (node.IsSequence()) return "a list";
    return node.IsScalar() ? fmt::format("'{}'", node.Scalar()) : "nothing";
  }

  Entries entries(const YAML::Node& node, const std::string& key, std::initializer_list<const char*> known) {
    Entries result;
    if (!node.IsMap()) {
      add(node, key, fmt::format("this should be a map, not {}", found(node)), fmt::format("see {}", kPage));
      return result;
    }
    for (const auto& entry : node) {
      const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "";
      const std::string full = key.empty() ? name : fmt::format("{}.{}", key, name);
      if (std::ranges::find(known, name) == known.end()) {
        add(entry.first, full, "there is no such key", fmt::format("the keys here are {}", fmt::join(known, ", ")));
      } else if (!result.emplace(name, entry.second).second) {
        add(entry.first, full, "this key is here twice", "keep one of them");
      }
    }
    return result;
  }

  // Returns `fallback` after a mistake.
  double number(const YAML::Node& node, const std::string& key, double min, double max, double fallback) {
    double value = 0.0;
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (!node.IsScalar() || error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      add(node, key, fmt::format("this should be a number, not {}", found(node)),
          "write metres, m/s, seconds or degrees, without a unit");
      return fallback;
    }
    if (value < min || value > max) {
      add(node, key, fmt::format("{} is out of range", text), fmt::format("write {} to {}", min, max));
      return fallback;
    }
    return value;
  }

  std::vector<double> numbers(const YAML::Node& node, const std::string& key, std::size_t count, const char* what) {
    if (!node.IsSequence() || node.size() != count) {
      add(node, key, fmt::format("this should be {}, not {}", what, found(node)),
          count == 2 ? "write [x, y]" : "write [left, bottom, right, top]");
      return {};
    }
    std::vector<double> values;
    const std::size_t before = problems_.size();
    for (const auto& item : node) values.push_back(number(item, key, -kLengthMax, kLengthMax, 0.0));
    if (problems_.size() != before) values.clear();
    return values;
  }

  std::optional<Point> point(const YAML::Node& node, const std::string& key) {
    const auto values = numbers(node, key, 2, "a point");
    if (values.empty()) return std::nullopt;
    return Point{values[0], values[1]};
  }

  std::vector<Point> points(const YAML::Node& node, const std::string& key, std::size_t min) {
    std::vector<Point> result;
    if (!node.IsSequence() || node.size() < min) {
      add(node, key, fmt::format("this should be a list of {} points or more", min), "write [[x, y], [x, y], ...]");
      return result;
    }
    const std::size_t before = problems_.size();
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::string item = fmt::format("{}[{}]", key, i);
      const auto read = point(node[i], item);
      if (!read) continue;
      if (!result.empty() && result.back() == *read) {
        add(node[i], item, "this point is the one before", "leave one of them out");
        continue;
      }
      result.push_back(*read);
    }
    if (problems_.size() != before) result.clear();
    return result;
  }

  bool flag(const YAML::Node& node, const std::string& key) {
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (text != "true" && text != "false") {
      add(node, key, fmt::format("this should be true or false, not {}", found(node)), "write true or false");
    }
    return text == "true";
  }

  void read_all(const YAML::Node& root) {
    root_at_ = place(root);
    const Entries keys = entries(
        root, "", {"catan_world", "name", "bounds", "walls", "blocks", "image", "robot", "goal", "explore", "movers"});
    if (!root.IsMap()) return;
    const auto with = [&](const char* key, auto&& read) {
      if (const auto at = keys.find(key); at != keys.end()) read(at->second, std::string(key));
    };
    if (!keys.contains("catan_world")) {
      add(root, "catan_world", "the version of the format is missing", "begin with catan_world: 1");
    }
    with("catan_world", [&](const YAML::Node& node, const std::string& key) { number(node, key, 1.0, 1.0, 1.0); });
    with("name", [&](const YAML::Node& node, const std::string& key) {
      if (!node.IsScalar()) add(node, key, "this should be a name", "write name: TEXT");
      world_.name = node.IsScalar() ? node.Scalar() : "";
    });
    with("walls", [&](const YAML::Node& node, const std::string& key) {
      each(node, key, "lines", [&](const YAML::Node& item, const std::string& name) {
        const std::vector<Point> line = points(item, name, 2);
        for (std::size_t i = 0; i + 1 < line.size(); ++i) world_.walls.push_back({line[i], line[i + 1]});
      });
    });
    with("blocks", [&](const YAML::Node& node, const std::string& key) {
      each(node, key, "blocks", [&](const YAML::Node& item, const std::string& name) {
        std::vector<Point> corners = points(item, name, 3);
        if (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
        if (corners.size() >= 3) add_block(world_, std::move(corners));
      });
    });
    with("image", [&](const YAML::Node& node, const std::string& key) { read_image(node, key); });
    with("bounds", [&](const YAML::Node& node, const std::string& key) {
      const auto values = numbers(node, key, 4, "a rectangle");
      if (values.empty()) return;
      world_.bounds = {{values[0], values[1]}, {values[2], values[3]}};
      has_bounds_ = true;
      if (world_.bounds.width() <= 0.0 || world_.bounds.height() <= 0.0) {
        add(node, key, "this rectangle is empty", "write [left, bottom, right, top]");
      }
    });
    with("robot", [&](const YAML::Node& node, const std::string& key) { read_robot(node, key); });
    if (!keys.contains("robot")) add(root, "robot", "where the robot starts is missing", "write robot: { at: [x, y] }");
    const bool explore = keys.contains("explore") && flag(keys.at("explore"), "explore");
    if (explore == keys.contains("goal")) {
      add(explore ? keys.at("goal") : root, "goal",
          explore ? "a robot that explores has no goal" : "what the robot is to do is missing",
          "write goal: [x, y] or explore: true");
    }
    with("goal", [&](const YAML::Node& node, const std::string& key) {
      world_.goal = point(node, key);
      goal_at_ = place(node);
    });
    with("movers", [&](const YAML::Node& node, const std::string& key) {
      each(node, key, "movers", [&](const YAML::Node& item, const std::string& name) { read_mover(item, name); });
    });
  }

  template <class Read>
  void each(const YAML::Node& node, const std::string& key, const char* what, Read read) {
    if (!node.IsSequence()) {
      add(node, key, fmt::format("this should be a list of {}, not {}", what, found(node)),
          fmt::format("see {}", kPage));
      return;
    }
    for (std::size_t i = 0; i < node.size(); ++i) read(node[i], fmt::format("{}[{}]", key, i));
  }

  void read_robot(const YAML::Node& node, const std::string& key) {
    const Entries keys = entries(node, key, {"at", "heading"});
    robot_at_ = place(node);
    if (const auto at = keys.find("at"); at != keys.end()) {
      robot_at_ = place(at->second);
      if (const auto where = point(at->second, key + ".at")) world_.start = {where->x, where->y, 0.0};
    } else if (node.IsMap()) {
      add(node, key + ".at", "where the robot starts is missing", "write at: [x, y]");
    }
    if (const auto heading = keys.find("heading"); heading != keys.end()) {
      world_.start.heading = number(heading->second, key + ".heading", -360.0, 360.0, 0.0) * kDegree;
    }
  }

  void read_mover(const YAML::Node& node, const std::string& key) {
    const Entries keys = entries(node, key, {"path", "speed", "size", "radius", "heading", "closed", "pause", "phase"});
    MoverSpec mover;
    const auto with = [&](const char* name, auto&& read) {
      const auto at = keys.find(name);
      if (at != keys.end()) read(at->second, key + "." + name);
      return at != keys.end();
    };
    const auto value = [&](const char* name, double min, double max, double fallback) {
      double read = fallback;
      with(name, [&](const YAML::Node& at, const std::string& full) { read = number(at, full, min, max, fallback); });
      return read;
    };
    for (const char* needed : {"path", "speed"}) {
      if (node.IsMap() && !keys.contains(needed)) add(node, key + "." + needed, "this key is missing", "add it");
    }
    with("path", [&](const YAML::Node& at, const std::string& full) { mover.path = points(at, full, 2); });
    mover.speed = value("speed", 0.01, 10.0, 1.0);
    mover.length = mover.width = kRobotSide;
    mover.radius = value("radius", 0.05, 5.0, 0.0);
    with("size", [&](const YAML::Node& at, const std::string& full) {
      if (keys.contains("radius")) add(at, full, "a mover that has a radius is round", "leave size or radius out");
      if (at.IsSequence() && at.size() == 2) {
        mover.length = number(at[0], full, 0.05, 10.0, 1.0);
        mover.width = number(at[1], full, 0.05, 10.0, 1.0);
      } else {
        mover.length = mover.width = number(at, full, 0.05, 10.0, 1.0);
      }
    });
    if (mover.radius > 0.0) mover.length = mover.width = 0.0;
    mover.heading = value("heading", -360.0, 360.0, 0.0) * kDegree;
    mover.pause = value("pause", 0.0, 3600.0, 0.0);
    with("closed", [&](const YAML::Node& at, const std::string& full) { mover.closed = flag(at, full); });
    with("phase", [&](const YAML::Node& at, const std::string& full) {
      if (at.IsScalar() && at.Scalar() == "any") {
        mover.phase = std::nullopt;
      } else {
        mover.phase = number(at, full, 0.0, 86400.0, 0.0);
      }
    });
    world_.movers.push_back(std::move(mover));
    mover_at_.push_back(place(node));
  }

  void read_image(const YAML::Node& node, const std::string& key) {
    const Entries keys = entries(node, key, {"file", "metres_per_pixel", "origin", "dark"});
    if (!node.IsMap()) return;
    for (const char* needed : {"file", "metres_per_pixel"}) {
      if (!keys.contains(needed)) add(node, key + "." + needed, "this key is missing", "add it");
    }
    Point origin;
    double dark = 128.0;
    if (const auto at = keys.find("origin"); at != keys.end())
      origin = point(at->second, key + ".origin").value_or(origin);
    if (const auto at = keys.find("dark"); at != keys.end())
      dark = number(at->second, key + ".dark", 1.0, 255.0, 128.0);
    if (!keys.contains("file") || !keys.contains("metres_per_pixel")) return;
    const double scale = number(keys.at("metres_per_pixel"), key + ".metres_per_pixel", 0.005, 10.0, 0.0);
    const YAML::Node& file = keys.at("file");
    if (!file.IsScalar()) {
      add(file, key + ".file", fmt::format("this should be the name of an image, not {}", found(file)),
          "write its name");
      return;
    }
    if (scale <= 0.0) return;
    cv::Mat image;
    const std::filesystem::path path = std::filesystem::path(folder_) / file.Scalar();
    std::error_code missing;
    try {
      if (std::filesystem::exists(path, missing)) image = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
    } catch (const cv::Exception&) {
      image = cv::Mat();
    }
    if (image.empty()) {
      add(file, key + ".file", fmt::format("there is no image {} that can be read", file.Scalar()),
          "name a PNG or PGM file, beside this one");
      return;
    }
    if (std::max(image.cols, image.rows) * scale > kLengthMax) {
      add(file, key + ".file", fmt::format("the image is {} x {} m", image.cols * scale, image.rows * scale),
          fmt::format("no world is longer than {} m", kLengthMax));
      return;
    }
    image_bounds_ = {origin, origin + Point{image.cols * scale, image.rows * scale}};
    std::ranges::copy(outline_of(image, scale, origin, dark), std::back_inserter(world_.walls));
  }

  void check() {
    if (world_.walls.empty()) {
      add(root_at_, "", "this world has no walls", "add walls, blocks or an image");
      return;
    }
    if (world_.walls.size() > kWallsMax) {
      add(root_at_, "", fmt::format("{} pieces of wall are too many", world_.walls.size()),
          fmt::format("use a coarser image: at most {}", kWallsMax));
      return;
    }
    Box around = image_bounds_.value_or(Box{world_.walls[0].from, world_.walls[0].from});
    for (const Segment& wall : world_.walls) {
      for (const Point end : {wall.from, wall.to}) {
        around.low = {std::min(around.low.x, end.x), std::min(around.low.y, end.y)};
        around.high = {std::max(around.high.x, end.x), std::max(around.high.y, end.y)};
      }
    }
    if (!has_bounds_) world_.bounds = around;
    if (!world_.bounds.contains(around.low) || !world_.bounds.contains(around.high)) {
      add(root_at_, "bounds", "there are walls outside these bounds",
          fmt::format("the walls need [{}, {}, {}, {}]", around.low.x, around.low.y, around.high.x, around.high.y));
    }
    if (world_.bounds.width() < kRobotSide || world_.bounds.height() < kRobotSide) {
      add(root_at_, "bounds", "there is no room for the robot", fmt::format("it is {} m square", kRobotSide));
      return;
    }
    check_inside(robot_at_, "robot.at", position(world_.start));
    if (world_.goal) check_inside(goal_at_, "goal", *world_.goal);
    for (std::size_t i = 0; i < world_.movers.size(); ++i) {
      for (const Point at : world_.movers[i].path) check_inside(mover_at_[i], fmt::format("movers[{}].path", i), at);
    }
    if (problems_.empty()) check_room();
  }

  void check_inside(const Place& place_in_file, const std::string& key, Point at) {
    if (world_.bounds.contains(at)) return;
    const Box& in = world_.bounds;
    add(place_in_file, key, fmt::format("[{}, {}] is outside the world", at.x, at.y),
        fmt::format("the world is from [{}, {}] to [{}, {}]", in.low.x, in.low.y, in.high.x, in.high.y));
  }

  void check_room() {
    const Scene scene(world_, 0);
    if (scene.to_walls(world_.start, kRobotSide, 1.0) <= 0.0) {
      add(robot_at_, "robot.at", "the robot starts in a wall", fmt::format("it is {} m square", kRobotSide));
      return;
    }
    for (std::size_t i = 0; i < world_.movers.size(); ++i) {
      const MoverSpec& mover = world_.movers[i];
      double nearest = scene.to_mover(i, world_.start, kRobotSide, 0.0);
      if (!mover.phase) {
        // Its phase is drawn, so it may be anywhere on its path when the robot starts.
        for (std::size_t at = 0; at < mover.path.size(); ++at) {
          if (at + 1 == mover.path.size() && !mover.closed) break;
          const Segment leg{mover.path[at], mover.path[(at + 1) % mover.path.size()]};
          nearest =
              std::min(nearest, distance(leg, position(world_.start)) - mover.reach() - kRobotSide / std::sqrt(2.0));
        }
      }
      if (nearest <= 0.0) {
        add(mover_at_[i], fmt::format("movers[{}]", i), "this mover may be where the robot starts",
            "move one of them, or give the mover another phase");
      }
    }
    if (!world_.goal) return;
    // Half the robot's side: what any robot of its width needs.
    const Grid grid(world_, kCoarse);
    if (!grid.path_exists(position(world_.start), *world_.goal, kRobotSide / 2.0)) {
      add(goal_at_, "goal", "the robot cannot get there",
          fmt::format("leave a way that is {} m wide", kRobotSide + kCoarse));
    }
  }

  std::string file_;
  std::string folder_;
  WorldFile world_;
  std::vector<Problem> problems_;
  bool has_bounds_ = false;
  std::optional<Box> image_bounds_;
  // Places in the file.
  Place root_at_;
  Place robot_at_;
  Place goal_at_;
  std::vector<Place> mover_at_;
};

}  // namespace

void add_block(WorldFile& world, std::vector<Point> corners) {
  std::ranges::copy(sides_of(corners), std::back_inserter(world.walls));
  world.blocks.push_back(std::move(corners));
}

Result<WorldFile> parse_world(std::string_view text, const std::string& file, const std::string& folder) {
  if (text.size() > kBytesMax) {
    return Error(ErrorKind::kCaller, {{{file, 0, 0}, "", "this file is too big", "keep it under 4 MiB"}});
  }
  try {
    return WorldReader(file, folder).read(YAML::Load(std::string(text)));
  } catch (const YAML::Exception& exception) {
    Place place{file, 1, 1};
    if (!exception.mark.is_null()) place = {file, exception.mark.line + 1, exception.mark.column + 1};
    return Error(ErrorKind::kCaller,
                 {{place, "", "this is not YAML: " + exception.msg, fmt::format("see {} for examples", kPage)}});
  }
}

Result<WorldFile> read_world(const std::string& path) {
  const auto text = program::text_of_file(path);
  if (!text) return Error::environment(fmt::format("{} cannot be read", path), "name a file that describes a world");
  return parse_world(*text, path, std::filesystem::path(path).parent_path().string());
}

std::string image_of(const std::string& path) {
  try {
    const YAML::Node world = YAML::Load(program::text_of_file(path).value_or(""));
    if (!world.IsMap() || !world["image"].IsMap() || !world["image"]["file"].IsScalar()) return {};
    return (std::filesystem::path(path).parent_path() / world["image"]["file"].Scalar()).string();
  } catch (const YAML::Exception&) {
    return {};
  }
}

}  // namespace ctn::navigation::world
