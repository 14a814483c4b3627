#include "page/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "page/buckets.h"
#include "page/losses.h"
#include "page/pack.h"
#include "report/escape.h"

namespace ctn::page {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxShares = 2'000'000;  // of all lanes together
constexpr std::size_t kMaxBands = 80'000;      // of all nodes together
constexpr std::size_t kMaxPoints = 300'000;    // single responses of all chains together
constexpr std::size_t kMaxEvents = 2000;
constexpr std::size_t kMaxPlans = 2000;
constexpr double kTenths = 1e4;  // of a microsecond in a millisecond: the unit of packed durations

std::int64_t tenths(double ms) { return std::llround(ms * kTenths); }

// The largest power of two that is at most `max` and `limit`; at least 64.
std::size_t power_of_two(std::size_t max, std::size_t limit) {
  std::size_t power = 64;
  while (2 * power <= std::min(max, limit)) power *= 2;
  return power;
}

class Data {
 public:
  Data(const Story& story, const Detail& detail) : story_(story), detail_(detail) {}

  json document(const std::string& name, const std::vector<std::string>& colours) {
    json document{
        {"name", name}, {"duration", story_.duration}, {"from", story_.measured_from}, {"cores", story_.cores}};
    document["detail"] = detail_.windows();
    for (std::size_t i = 0; i < story_.lanes.size(); ++i) {
      json lane{{"name", story_.lanes[i].name}, {"scheduled", story_.lanes[i].scheduled}, {"colour", colours[i]}};
      for (const NodeId node : story_.lanes[i].nodes) lane["nodes"].push_back(node.index());
      document["lanes"].push_back(std::move(lane));
    }
    const std::size_t buckets = power_of_two(16384, kMaxShares / std::max<std::size_t>(story_.lanes.size(), 1));
    document["share"] = json::array();
    for (const auto& shares : busy_shares(story_, buckets)) document["share"].push_back(base64(shares));
    document["buckets"] = buckets;
    put_nodes(document);
    put_triggers(document);
    put_slots(document);
    put_chains(document);
    put_plans(document);
    put_events(document);
    return document;
  }

 private:
  void put_nodes(json& document) {
    const auto nodes = story_.app.graph.nodes();
    std::vector<std::vector<const RunSpan*>> runs(nodes.size());
    for (const RunSpan& run : story_.runs) runs[run.node].push_back(&run);
    buckets_ = power_of_two(1024, kMaxBands / std::max<std::size_t>(nodes.size(), 1));
    document["nodes"] = json::array();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      json node{{"name", nodes[i].name}, {"modes", nodes[i].modes}};
      if (story_.lane_of[i] != kNoLane) {
        node["lane"] = story_.lane_of[i];
        put_runs(node, runs[i]);
        node["compute"] = compute_bands(runs[i], std::max<std::size_t>(nodes[i].modes.size(), 1));
      }
      document["nodes"].push_back(std::move(node));
    }
  }

  void put_runs(json& node, const std::vector<const RunSpan*>& runs) const {
    Packer packed;
    Micros last = 0;
    std::uint64_t number = 0;
    std::size_t count = 0;
    for (const RunSpan* const run : runs) {
      if (!detail_.has(run->begin)) continue;
      ++count;
      packed.add(run->begin - last);
      packed.add(run->end - run->begin);
      packed.add(tenths(static_cast<double>(run->cpu_ms)));
      packed.add(tenths(static_cast<double>(run->wait_ms)));
      packed.add(static_cast<std::int64_t>(run->number - number));
      packed.add(run->mode);
      const std::vector<Loss> losses = losses_of(story_, *run);
      packed.add(static_cast<std::int64_t>(losses.size()));
      Micros from = run->begin;
      for (const Loss& loss : losses) {
        packed.add(loss.begin - from);
        packed.add(loss.end - loss.begin);
        packed.add(static_cast<std::int64_t>(loss.lane));
        from = loss.end;
      }
      last = std::max(last, run->begin);
      number = run->number;
    }
    node["runs"] = packed.text();
    node["count"] = count;
  }

  // In few enough buckets that the 95th percentile of one means something.
  json packed_bands(const std::vector<Sample>& samples) const {
    const std::size_t buckets = power_of_two(buckets_, samples.size() / 40);
    Packer packed;
    packed.add(static_cast<std::int64_t>(buckets));
    std::size_t last = 0;
    for (const Band& band : bands(samples, story_.duration, buckets)) {
      packed.add(static_cast<std::int64_t>(band.bucket - last));
      for (const double value : {band.min, band.mean, band.p95, band.max}) packed.add(tenths(value));
      last = band.bucket;
    }
    return packed.text();
  }

  json compute_bands(const std::vector<const RunSpan*>& runs, std::size_t modes) const {
    std::vector<std::vector<Sample>> samples(modes);
    for (const RunSpan* const run : runs) {
      samples[std::min<std::size_t>(run->mode, modes - 1)].push_back({run->end, static_cast<double>(run->cpu_ms)});
    }
    json result = json::array();
    for (const auto& of_mode : samples) result.push_back(packed_bands(of_mode));
    return result;
  }

  void put_triggers(json& document) const {
    document["triggers"] = json::array();
    for (const auto& triggers : story_.triggers) {
      Packer packed;
      Micros last = 0;
      for (const TriggerPoint& trigger : triggers) {
        if (!detail_.has(trigger.sent)) continue;
        packed.add(trigger.sent - last);
        packed.add(trigger.late);
        last = trigger.sent;
      }
      document["triggers"].push_back(packed.text());
    }
  }

  static void pack_slot(Packer& packed, const SlotSpan& slot, Micros& last) {
    packed.add(slot.begin - last);
    packed.add(slot.end - slot.begin);
    packed.add(static_cast<std::int64_t>(slot.core));
    packed.add(static_cast<std::int64_t>(slot.lane));
    last = slot.begin;
  }

  void put_slots(json& document) const {
    Packer slots;
    Micros last = 0;
    for (const SlotSpan& slot : story_.slots) {
      if (detail_.has(slot.begin)) pack_slot(slots, slot, last);
    }
    Packer steals;
    last = 0;
    for (const StealSpan& steal : story_.steals) {
      if (!detail_.has(steal.slot.begin)) continue;
      pack_slot(steals, steal.slot, last);
      steals.add(static_cast<std::int64_t>(steal.victim));
    }
    document["slots"] = slots.text();
    document["steals"] = steals.text();
  }

  void put_chains(json& document) const {
    std::size_t total = 0;
    for (const auto& responses : story_.responses) total += responses.size();
    document["chains"] = json::array();
    for (std::size_t i = 0; i < story_.responses.size(); ++i) {
      const report::ChainMetrics& metrics = story_.figures.chains[i];
      json chain{{"name", metrics.path}, {"bound", nullptr}, {"worst", json::array()}};
      if (metrics.bound_ms) chain["bound"] = *metrics.bound_ms;
      for (const ResponsePoint& worst : worst_responses(story_.responses[i], 5)) {
        chain["worst"].push_back({worst.end, worst.response_ms});
      }
      std::vector<Sample> samples;
      Packer points;
      Micros last = 0;
      for (const ResponsePoint& response : story_.responses[i]) {
        samples.push_back({response.end, response.response_ms});
        if (total > kMaxPoints && !detail_.has(response.end)) continue;
        points.add(response.end - last);
        points.add(tenths(response.response_ms));
        last = response.end;
      }
      chain["band"] = packed_bands(samples);
      chain["points"] = points.text();
      document["chains"].push_back(std::move(chain));
    }
    document["all_points"] = total <= kMaxPoints;
  }

  // Plans that change nothing of what is drawn are left out here; their marks are among the events.
  void put_plans(json& document) const {
    document["plans"] = json::array();
    const PlanSpan* last = nullptr;
    for (const PlanSpan& plan : story_.plans) {
      if (last != nullptr && last->placements == plan.placements && last->chains == plan.chains) continue;
      last = &plan;
      if (document["plans"].size() >= kMaxPlans) break;
      json entry{{"at", plan.at}, {"on", json::array()}, {"chains", json::array()}};
      for (const Placement& one : plan.placements) entry["on"].push_back({one.lane, one.core, one.priority});
      for (const Promise& promise : plan.chains) {
        entry["chains"].push_back({promise.promised_ms, promise.expected_ms ? json(*promise.expected_ms) : json()});
      }
      document["plans"].push_back(std::move(entry));
    }
  }

  void put_events(json& document) const {
    document["events"] = json::array();
    for (const Event& event : story_.events) {
      if (document["events"].size() >= kMaxEvents) break;
      json entry{
          {"at", event.at}, {"kind", to_string(event.kind)}, {"text", report::cleaned(event.text.substr(0, 400))}};
      if (event.lane) entry["lane"] = *event.lane;
      if (event.node) entry["node"] = *event.node;
      document["events"].push_back(std::move(entry));
    }
  }

  const Story& story_;
  const Detail& detail_;
  std::size_t buckets_ = 64;  // of bands, at most
};

}  // namespace

std::string data_of(const Story& story, const std::string& name, const Detail& detail,
                    const std::vector<std::string>& colours) {
  const json document = Data(story, detail).document(report::cleaned(name), colours);
  const std::string text = document.dump(-1, ' ', true, json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {  // so that no text ends the element that holds the document, or begins a comment
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::vector<ModeSamples> compute_samples_ms(const Story& story) {
  const auto nodes = story.app.graph.nodes();
  std::vector<ModeSamples> samples(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) samples[i].resize(std::max<std::size_t>(nodes[i].modes.size(), 1));
  for (const RunSpan& run : story.runs) {
    if (run.begin < story.measured_from) continue;
    ModeSamples& modes = samples[run.node];
    modes[std::min<std::size_t>(run.mode, modes.size() - 1)].push_back(static_cast<double>(run.cpu_ms));
  }
  return samples;
}

}  // namespace ctn::page
