#include "run/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include <nlohmann/json.hpp>

#include "nodes/grid.h"
#include "replay_page.h"
#include "robot.h"

namespace ctn::navigation::run {
namespace {

using std::chrono::nanoseconds;
using PageJson = nlohmann::ordered_json;

constexpr std::size_t kFramesForALocalMap = 2;
constexpr int kCoarser = 2;  // cells of the map of everything that become one, each way

int rounded(double value) { return static_cast<int>(std::lround(value)); }
int in_cm(double metres) { return rounded(100.0 * metres); }
double time_in_seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

void append(std::string& list, const PageJson& element) {
  if (!list.empty()) list += ",\n";
  list += element.dump();
}

// A number in digits of 64 values, the last of which has its high bit: short for small numbers.
constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
void append_number(std::string& text, std::size_t number) {
  while (number >= 32) {
    text += kDigits[number % 32];
    number /= 32;
  }
  text += kDigits[number + 32];
}

// Lengths of the runs of equal values, row by row, each followed by its value.
std::string runs_of(const std::vector<int>& values) {
  std::string text;
  for (std::size_t begin = 0; begin < values.size();) {
    std::size_t end = begin;
    while (end < values.size() && values[end] == values[begin]) ++end;
    append_number(text, end - begin);
    append_number(text, static_cast<std::size_t>(values[begin]));
    begin = end;
  }
  return text;
}

// What is an obstacle in any of the cells is one.
PageJson coarse_map_of(const GlobalMap& map) {
  const int width = (map.frame.width + kCoarser - 1) / kCoarser;
  const int height = (map.frame.height + kCoarser - 1) / kCoarser;
  std::vector<int> cells(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  for (int row = 0; row < map.frame.height; ++row) {
    for (int column = 0; column < map.frame.width; ++column) {
      int& cell = cells[static_cast<std::size_t>(row / kCoarser) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(column / kCoarser)];
      cell = std::max(cell, static_cast<int>(map.cells[map.frame.index(column, row)]));
    }
  }
  return {{"x", map.frame.left * kCell}, {"y", map.frame.bottom * kCell}, {"w", width}, {"h", height},
          {"cell", kCoarser * kCell},    {"runs", runs_of(cells)}};
}

PageJson points_of(const std::vector<Point>& points) {
  PageJson list = PageJson::array();
  for (const Point& point : points) {
    list.push_back(in_cm(point.x));
    list.push_back(in_cm(point.y));
  }
  return list;
}

PageJson world_of_page(const world::WorldFile& file) {
  PageJson world = {{"name", file.name},
                    {"bounds", {file.bounds.low.x, file.bounds.low.y, file.bounds.high.x, file.bounds.high.y}},
                    {"walls", PageJson::array()},
                    {"blocks", PageJson::array()}};
  for (const Segment& wall : file.walls) {
    world["walls"].push_back({in_cm(wall.from.x), in_cm(wall.from.y), in_cm(wall.to.x), in_cm(wall.to.y)});
  }
  for (const auto& block : file.blocks) world["blocks"].push_back(points_of(block));
  world["goal"] = file.goal ? PageJson({file.goal->x, file.goal->y}) : PageJson(nullptr);
  return world;
}

PageJson events_of(const Findings& found) {
  PageJson contacts = PageJson::array();
  for (const world::Contact& contact : found.contacts) {
    contacts.push_back({time_in_seconds(contact.at), in_cm(contact.pose.x), in_cm(contact.pose.y)});
  }
  PageJson appearances = PageJson::array();
  for (const Appearance& appearance : found.appearances) {
    appearances.push_back({time_in_seconds(appearance.at),
                           appearance.reaction ? PageJson(1e3 * time_in_seconds(*appearance.reaction)) : PageJson()});
  }
  PageJson detections = PageJson::array();
  for (const nanoseconds at : found.detections) detections.push_back(std::round(1e3 * time_in_seconds(at)) / 1e3);
  return {{"contacts", std::move(contacts)},
          {"appearances", std::move(appearances)},
          {"detections", std::move(detections)}};
}

// Inside a <script>: nothing in it may end it.
std::string for_script(std::string json) {
  for (std::size_t at = json.find("</"); at != std::string::npos; at = json.find("</", at)) json.replace(at, 2, "<\\/");
  return json;
}

}  // namespace

Frame frame_of(Drive& drive) {
  Frame frame;
  frame.at = drive.world().now();
  frame.robot = drive.world().truth();
  frame.motion = drive.motion();
  if (frame.motion.map) frame.scanned_from = drive.world().truth_at(frame.motion.map->stamp);
  frame.plan = drive.plan();
  return frame;
}

Replay::Replay(world::WorldFile file, std::vector<world::Mover> movers, double seconds)
    : file_(std::move(file)),
      movers_(std::move(movers)),
      map_every_(std::max<nanoseconds>(std::chrono::seconds(1),
                                       nanoseconds(std::llround(1e9 * seconds / static_cast<double>(kMaxMaps))))) {}

void Replay::add(const Frame& frame) {
  times_.push_back(std::round(1e3 * time_in_seconds(frame.at)) / 1e3);
  for (const int value : {in_cm(frame.robot.x), in_cm(frame.robot.y), rounded(1e3 * frame.robot.heading)}) {
    poses_.push_back(value);
  }
  motions_.push_back(rounded(1e3 * frame.motion.velocity.linear));
  motions_.push_back(rounded(1e3 * frame.motion.velocity.angular));
  for (const world::Mover& mover : movers_) {
    const Point at = mover.at(time_in_seconds(frame.at));
    positions_.push_back(in_cm(at.x));
    positions_.push_back(in_cm(at.y));
  }
  if (frames_++ % kFramesForALocalMap == 0) add_local_map(frame);
  add_plan(frame);
}

void Replay::add_local_map(const Frame& frame) {
  const std::shared_ptr<const LocalMap>& map = frame.motion.map;
  if (!map || map == newest_local_) return;
  newest_local_ = map;
  std::string cells;  // distances between cells that are obstacles
  std::size_t last = 0;
  for (std::size_t cell = 0; cell < map->clearance.size(); ++cell) {
    if (map->clearance[cell] > 0.0F) continue;
    append_number(cells, cell - last);
    last = cell;
  }
  // The odometry drifts, and the map with it: it is drawn from where the robot was when it took the scan.
  const Pose& by_wheels = map->odometry.pose;
  const Pose& was = frame.scanned_from;
  append(local_maps_, {{"t", time_in_seconds(frame.at)},
                       {"x", map->frame.left * kCell},
                       {"y", map->frame.bottom * kCell},
                       {"w", map->frame.width},
                       {"from", {by_wheels.x, by_wheels.y, by_wheels.heading}},
                       {"to", {was.x, was.y, was.heading}},
                       {"cells", cells}});
}

void Replay::add_plan(const Frame& frame) {
  const Planned& plan = frame.plan;
  if (plan.path && plan.path != newest_path_) {
    newest_path_ = plan.path;
    append(paths_, {{"t", time_in_seconds(frame.at)}, {"points", points_of(plan.path->points)}});
  }
  const bool due = last_map_ < nanoseconds(0) || frame.at - last_map_ >= map_every_;
  if (!plan.map || plan.map == newest_map_ || !due) return;
  newest_map_ = plan.map;
  last_map_ = frame.at;
  PageJson map = coarse_map_of(*plan.map);
  map["t"] = time_in_seconds(frame.at);
  append(maps_, map);
}

std::string Replay::data(const Outcome& outcome) const {
  PageJson figures = PageJson::object();
  for (const Figure& figure : figures_of(outcome)) {
    figures[figure.name] = figure.value ? PageJson(*figure.value) : PageJson(nullptr);
  }
  PageJson staleness = PageJson::array();
  for (const auto& p95 :
       p95_by_time(outcome.findings.guidance_ages, std::chrono::seconds(1), outcome.findings.lasted)) {
    staleness.push_back(p95 ? PageJson(std::round(*p95)) : PageJson(nullptr));
  }
  PageJson sizes = PageJson::array();
  for (const world::Mover& mover : movers_) {
    const world::MoverSpec& spec = mover.spec();
    sizes.push_back({in_cm(spec.length), in_cm(spec.width), rounded(1e3 * spec.heading), in_cm(spec.radius)});
  }
  PageJson head = {{"title", fmt::format("{} under {}", outcome.world, outcome.options.scheduler)},
                   {"note", note_of(outcome.options)},
                   {"world", world_of_page(file_)},
                   {"robot", kRobotSide},
                   {"lasted", time_in_seconds(outcome.findings.lasted)},
                   {"figures", std::move(figures)},
                   {"staleness", std::move(staleness)},
                   {"movers", std::move(sizes)},
                   {"times", times_},
                   {"poses", poses_},
                   {"motions", motions_},
                   {"positions", positions_}};
  head.update(events_of(outcome.findings));
  std::string json = head.dump(-1, ' ', false, PageJson::error_handler_t::replace);
  json.pop_back();
  return fmt::format("{},\n\"paths\":[{}],\n\"maps\":[{}],\n\"locals\":[{}]}}\n", json, paths_, maps_, local_maps_);
}

Status Replay::write(const Outcome& outcome, const std::string& path) const {
  std::string page = kReplayPage;
  const std::string kPlace = "@DATA@";
  page.replace(page.find(kPlace), kPlace.size(), for_script(data(outcome)));
  if (!(std::ofstream(path, std::ios::binary) << page).flush()) {
    return Error::environment(fmt::format("{} cannot be written", path), "name another file with --replay");
  }
  return Done{};
}

}  // namespace ctn::navigation::run
