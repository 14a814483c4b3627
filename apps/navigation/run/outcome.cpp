#include "run/outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>

#include "program/snapshot_json.h"
#include "robot.h"
#include "run/objective.h"
#include "run/shortest_way.h"

namespace ctn::navigation::run {
namespace {

using Json = nlohmann::ordered_json;
using program::name_of;
using program::or_null;
using std::chrono::nanoseconds;

double in_seconds(nanoseconds time) { return std::chrono::duration<double>(time).count(); }

std::optional<double> in_seconds(const std::optional<nanoseconds>& time) {
  return time ? std::optional(in_seconds(*time)) : std::nullopt;
}

const char* name_of(const Outcome& outcome) {
  if (outcome.signal != 0) return "interrupted";
  switch (outcome.findings.ending) {
    case Ending::kGoal:
      return "goal";
    case Ending::kExplored:
      return "explored";
    case Ending::kTime:
      break;
  }
  return "time";
}

std::string name_of(const world::Contact& contact) {
  return contact.mover ? fmt::format("mover {}", *contact.mover) : "wall";
}

std::vector<double> reactions_in_ms(const Findings& findings) {
  std::vector<double> reactions;
  for (const Appearance& appearance : findings.appearances) {
    if (appearance.reaction) reactions.push_back(1e3 * in_seconds(*appearance.reaction));
  }
  return reactions;
}

void add_goal(const Findings& found, const std::optional<double>& shortest_way, std::vector<Figure>& figures) {
  const bool success = found.reached_at && found.contacts.empty();
  const double optimal = shortest_way.value_or(0.0) / RobotLimits().speed;
  figures.push_back({"reached_goal", found.reached_at ? 1.0 : 0.0});
  figures.push_back({"goal_s", in_seconds(found.reached_at)});
  std::optional<double> score;
  if (optimal > 0.0) score = barn_score(success, optimal, in_seconds(found.reached_at).value_or(8.0 * optimal));
  figures.push_back({"barn_score", score});
}

Json json_of(const Options& options) {
  Json json = {{"map", options.map},
               {"scheduler", options.scheduler},
               {"stealing", options.stealing},
               {"seconds", options.seconds},
               {"seed", options.seed},
               {"slowdown", options.slowdown},
               {"mover_speed", options.mover_speed},
               {"detector", options.detector},
               {"virtual", options.virtual_time}};
  program::add_machine(options, json);
  return json;
}

ByTime staleness_of(const Findings& found) { return p95_by_time(found.guidance_ages, kStalenessBucket, found.lasted); }

ByTime detector_periods_of(const Findings& found) {
  return period_by_time(found.detections, kDetectorBucket, found.lasted);
}

Json contacts_of(const Findings& found) {
  Json contacts = Json::array();
  for (const world::Contact& contact : found.contacts) {
    contacts.push_back({{"at_s", in_seconds(contact.at)},
                        {"with", name_of(contact)},
                        {"x", contact.pose.x},
                        {"y", contact.pose.y},
                        {"speed", contact.speed}});
  }
  return contacts;
}

Json appearances_of(const Findings& found) {
  Json appearances = Json::array();
  for (const Appearance& appearance : found.appearances) {
    std::optional<double> reaction;
    if (appearance.reaction) reaction = 1e3 * in_seconds(*appearance.reaction);
    appearances.push_back(
        {{"at_s", in_seconds(appearance.at)}, {"mover", appearance.mover}, {"reaction_ms", or_null(reaction)}});
  }
  return appearances;
}

}  // namespace

Outcome outcome_of_run(const Options& options, const world::WorldFile& world) {
  Outcome outcome;
  outcome.options = options;
  outcome.world = world.name;
  outcome.explores = world.explore();
  outcome.shortest_way = shortest_way(world);
  return outcome;
}

std::vector<Figure> drive_figures(const Findings& found, bool explores, const std::optional<double>& shortest_way) {
  const std::vector<double> guidance = ages_in_ms(found.guidance_ages);
  const std::vector<double> scans = ages_in_ms(found.scan_ages);
  std::vector<Figure> figures;
  figures.push_back({"seconds", in_seconds(found.lasted)});
  figures.push_back({"collided", found.contacts.empty() ? 0.0 : 1.0});
  figures.push_back({"contacts", static_cast<double>(found.contacts.size())});
  figures.push_back({"way_m", found.way});
  if (explores) {
    figures.push_back({"explored", found.explored});
    figures.push_back({"explored_90_s", in_seconds(found.explored_90_at)});
  } else {
    add_goal(found, shortest_way, figures);
  }
  figures.push_back({"staleness_ms_mean", mean_of(guidance)});
  figures.push_back({"staleness_ms_p95", percentile_of(guidance, 95.0)});
  figures.push_back({"scan_age_ms_mean", mean_of(scans)});
  figures.push_back({"scan_age_ms_p95", percentile_of(scans, 95.0)});
  figures.push_back({"pose_error_m_mean", mean_of(found.pose_errors)});
  figures.push_back({"pose_error_m_p95", percentile_of(found.pose_errors, 95.0)});
  figures.push_back({"pose_error_m_max", percentile_of(found.pose_errors, 100.0)});
  return figures;
}

std::vector<Figure> figures_of(const Outcome& outcome) {
  const Findings& found = outcome.findings;
  const std::vector<double> reactions = reactions_in_ms(found);
  std::vector<Figure> figures = drive_figures(found, outcome.explores, outcome.shortest_way);
  figures.push_back({"appearances", static_cast<double>(found.appearances.size())});
  figures.push_back({"reacted", static_cast<double>(reactions.size())});
  figures.push_back({"reaction_ms_mean", mean_of(reactions)});
  figures.push_back({"reaction_ms_p95", percentile_of(reactions, 95.0)});
  if (outcome.options.detector != "none") {
    const std::vector<nanoseconds>& outputs = found.detections;
    figures.push_back({"detector_outputs", static_cast<double>(outputs.size())});
    std::optional<double> period;
    if (outputs.size() > 1) {
      period = 1e3 * in_seconds(outputs.back() - outputs.front()) / static_cast<double>(outputs.size() - 1);
    }
    figures.push_back({"detector_period_ms_mean", period});
  }
  figures.push_back({"objective_ms", objective_of(outcome.snapshot)});
  for (const ChainSnapshot& chain : outcome.snapshot.chains) {
    const bool any = chain.response_ms.count > 0;
    figures.push_back(
        {"response_ms_mean " + name_of(chain), any ? std::optional(chain.response_ms.mean) : std::nullopt});
    figures.push_back({"response_ms_p95 " + name_of(chain), any ? std::optional(chain.response_ms.p95) : std::nullopt});
  }
  return figures;
}

std::string rows_of(const std::string& name, const ByTime& values, nanoseconds width) {
  constexpr std::size_t kInARow = 10;
  std::string text = fmt::format("  {}\n", name);
  for (std::size_t index = 0; index < values.size(); ++index) {
    if (index % kInARow == 0) text += fmt::format("  {:>6.0f} s ", in_seconds(width) * static_cast<double>(index));
    text += values[index] ? fmt::format(" {:>8.1f}", *values[index]) : fmt::format(" {:>8}", "-");
    if (index % kInARow == kInARow - 1 || index + 1 == values.size()) text += "\n";
  }
  return text;
}

std::string identity_of(const Options& options) { return json_of(options).dump(); }

std::string common_of(const Options& options) { return program::text_of(program::in_common(json_of(options))); }

std::string to_json(const Outcome& outcome) {
  const Options& options = outcome.options;
  const Findings& found = outcome.findings;
  Json json = json_of(options);
  json["world"] = outcome.world;
  if (!options.virtual_time) json["real_time"] = outcome.snapshot.real_time;
  program::add_in_common(json_of(options), json);
  json["ended_by"] = name_of(outcome);
  json["figures"] = program::json_of(figures_of(outcome));
  json["staleness_ms_p95_by_5s"] = program::json_of(staleness_of(found));
  if (options.detector != "none") json["detector_period_ms_by_10s"] = program::json_of(detector_periods_of(found));
  json["objective_ms_by_10s"] = program::json_of(outcome.objective_by_time);
  json["contacts"] = contacts_of(found);
  json["appearances"] = appearances_of(found);
  program::add_snapshot(outcome.snapshot, outcome.cost_ratios, json);
  if (outcome.world_thread) json["world_thread"] = program::json_of(*outcome.world_thread);
  return program::text_of(json);
}

std::string to_text(const Outcome& outcome) {
  const Options& options = outcome.options;
  const std::string machine = program::machine_of(options.virtual_time, options.cores, outcome.snapshot);
  std::string text = fmt::format("navigation in '{}' under '{}'{}, seed {}, slowdown {}, {}; ended by: {}\n",
                                 outcome.world, options.scheduler, options.stealing ? "" : " without stealing",
                                 options.seed, options.slowdown, machine, name_of(outcome));
  text += program::list_of(figures_of(outcome));
  text += rows_of("staleness_ms_p95 by 5 s", staleness_of(outcome.findings), kStalenessBucket);
  if (options.detector != "none") {
    text += rows_of("detector_period_ms by 10 s", detector_periods_of(outcome.findings), kDetectorBucket);
  }
  for (const world::Contact& contact : outcome.findings.contacts) {
    text += fmt::format("  contact with {} after {:.3f} s at ({:.2f}, {:.2f}), {:.2f} m/s\n", name_of(contact),
                        in_seconds(contact.at), contact.pose.x, contact.pose.y, contact.speed);
  }
  text += program::table_of_nodes(outcome.snapshot, outcome.cost_ratios);
  if (outcome.world_thread) {
    text += fmt::format("  world's thread: {:.2f} % of a CPU; readings at most {:.1f} ms late\n",
                        100.0 * outcome.world_thread->cpu_share, outcome.world_thread->late_ms_max);
    if (outcome.world_thread->lost > 0) {
      text += fmt::format(
          "  LOST: the world's thread came too late for {} of LP's, NC's and GP's outputs, which neither "
          "the robot nor the figures above know; leave it a CPU with --cpus\n",
          outcome.world_thread->lost);
    }
  }
  return text;
}

std::string status_line(const Progress& progress) {
  return fmt::format("{:6.1f} s  {:.1f} m driven, {} contact{}{}", in_seconds(progress.at), progress.way,
                     progress.contacts, progress.contacts == 1 ? "" : "s",
                     progress.explored > 0.0 ? fmt::format(", {:.1f} % explored", 100.0 * progress.explored) : "");
}

}  // namespace ctn::navigation::run
