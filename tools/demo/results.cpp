#include "results.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace ctn::demo {
namespace {

using Json = nlohmann::ordered_json;

Error not_as_expected(const std::string& what, const std::string& why) {
  return Error::environment(fmt::format("{} is not what was expected: {}", what, why),
                            "are the programs of one and the same build?");
}

Compute compute_of(const Json& json) { return {json.at("camera"), json.at("detect"), json.at("plan")}; }

Json json_of(const Measured& run) {
  const Compute& compute = run.compute;
  Json json = {
      {"round", run.trial.round},
      {"cpus", run.trial.cpus},
      {"scheduler", run.trial.scheduler},
      {"speed_rad_s", run.trial.speed},
      {"seed", run.trial.seed},
      {"seconds", run.trial.seconds},
      {"response_time_ms", run.response_ms},
      {"response_time_p95_ms", run.response_p95_ms},
      {"predicted_response_time_ms", nullptr},
      {"source_hz", run.source_hz},
      {"angle_deg_mean", run.angle_deg},
      {"lost_fraction", run.lost_fraction},
      {"compute_ms", {{"camera", compute.camera}, {"detect", compute.detect}, {"plan", compute.plan}}},
      {"real_time", run.real_time},
      {"used_by_others", run.others},
  };
  if (run.predicted_ms) json["predicted_response_time_ms"] = *run.predicted_ms;
  return json;
}

// What face_tracking prints and results.json keeps under the same keys.
void read_common(const Json& json, Measured& run) {
  if (!json.at("predicted_response_time_ms").is_null()) run.predicted_ms = json.at("predicted_response_time_ms");
  run.source_hz = json.at("source_hz");
  run.angle_deg = json.at("angle_deg_mean");
  run.lost_fraction = json.at("lost_fraction");
  run.compute = compute_of(json.at("compute_ms"));
  run.real_time = json.at("real_time");
}

Measured run_of(const Json& json) {
  Measured run;
  run.trial = {json.at("round"),       json.at("cpus"), json.at("scheduler"),
               json.at("speed_rad_s"), json.at("seed"), json.at("seconds")};
  run.response_ms = json.at("response_time_ms");
  run.response_p95_ms = json.at("response_time_p95_ms");
  read_common(json, run);
  run.others = json.at("used_by_others");
  return run;
}

}  // namespace

Result<Measured> parse_measured(const Trial& trial, const std::string& text) {
  try {
    const Json json = Json::parse(text);
    Measured run;
    run.trial = trial;
    if (const Json& response = json.at("response_time_ms"); !response.at("mean").is_null()) {
      run.response_ms = response.at("mean");
      run.response_p95_ms = response.at("p95");
    }
    read_common(json, run);
    return run;
  } catch (const nlohmann::json::exception& error) {
    return not_as_expected("what face_tracking printed", error.what());
  }
}

std::string to_json(const Results& results) {
  Json host = Json::object();
  for (const auto& [name, value] : results.host) host[name] = value;
  Json runs = Json::array();
  for (const Measured& run : results.runs) runs.push_back(json_of(run));
  const Json json = {
      {"made_by", "catan_demo"},
      {"version", 1},
      {"host", host},
      {"medium_speed_rad_s", results.medium_speed},
      {"high_speed_rad_s", results.high_speed},
      {"slowdown", results.slowdown},
      {"quick", results.quick},
      {"complete", results.complete},
      {"no_real_time", results.no_real_time},
      {"runs", runs},
  };
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Results> parse_results(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    if (json.at("made_by") != "catan_demo" || json.at("version") != 1) {
      return not_as_expected("the file of results", "it is of another program or version");
    }
    Results results;
    for (const auto& [name, value] : json.at("host").items()) results.host.emplace_back(name, value);
    results.medium_speed = json.at("medium_speed_rad_s");
    results.high_speed = json.at("high_speed_rad_s");
    results.slowdown = json.at("slowdown");
    results.quick = json.at("quick");
    results.complete = json.at("complete");
    results.no_real_time = json.at("no_real_time");
    for (const Json& run : json.at("runs")) results.runs.push_back(run_of(run));
    return results;
  } catch (const nlohmann::json::exception& error) {
    return not_as_expected("the file of results", error.what());
  }
}

}  // namespace ctn::demo
