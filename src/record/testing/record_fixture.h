// For tests of records: an app with one of everything, events of it, and a folder of their own.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/testing/times.h"
#include "graph/build.h"
#include "record/reader.h"
#include "record/writer.h"

namespace ctn::record::test {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

// A folder that goes with all that is in it.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "catan-record-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline std::vector<graph::Name> names(const std::string& words) {
  std::vector<graph::Name> result;
  std::istringstream stream(words);
  for (std::string word; stream >> word;) result.push_back({word, {}});
  return result;
}

// imu (unscheduled) and scan -> LM -> LP -> base (external); scan -> GL (queue, two modes) -> LP; LP -> lamp (ticks).
inline graph::App robot() {
  graph::AppSpec spec;
  spec.name.value = "robot";
  for (const char* name : {"imu", "scan", "LM", "LP", "GL", "base", "lamp"}) {
    spec.nodes.push_back({});
    spec.nodes.back().name.value = name;
  }
  spec.nodes[0].unscheduled = true;
  spec.nodes[0].period = graph::At<Nanos>{milliseconds{5}, {}};
  spec.nodes[1].max_rate = graph::At<Rate>{Rate{50.0}, {}};
  spec.nodes[1].fallback_rate = graph::At<Rate>{Rate{100.0 / 3.0}, {}};
  spec.nodes[2].max_threads = graph::At<int>{2, {}};
  spec.nodes[3].needs_input = true;
  spec.nodes[4].input = graph::InputKind::kQueue;
  spec.nodes[4].modes = names("skip match");
  spec.nodes[4].output_period = graph::At<Nanos>{milliseconds{667}, {}};
  spec.nodes[4].min_rate = graph::At<Rate>{Rate{0.5}, {}};
  spec.nodes[5].external = true;
  spec.nodes[6].external = true;
  spec.nodes[6].period = graph::At<Nanos>{Nanos{8'333'333}, {}};
  spec.edges = {
      {names("imu LM"), {}}, {names("scan LM LP base"), {}}, {names("scan GL LP"), {}}, {names("LP lamp"), {}}};
  spec.edges[0].max_age = graph::At<Nanos>{milliseconds{50}, {}};
  spec.edges[0].on_stale = graph::At<graph::OnStale>{graph::OnStale::kSkip, {}};
  spec.edges[2].max_age = graph::At<Nanos>{milliseconds{100}, {}};
  spec.subchains = {{{"local", {}}, names("scan LM LP")}};
  spec.objective.resize(3);
  spec.objective[0].path = names("scan LM LP base");
  spec.objective[0].weight.value = 1.0;
  spec.objective[0].max = graph::At<Nanos>{milliseconds{60}, {}};
  spec.objective[1].metric = graph::Metric::kPeriod;
  spec.objective[1].path = names("GL");
  spec.objective[1].weight.value = 0.5;
  spec.objective[2].path = names("GL LP base");
  spec.objective[2].weight.value = 0.005;
  spec.core_kinds = {{{"big", {}}, {2, {}}, {1.0, {}}}, {{"little", {}}, {4, {}}, {0.45, {}}}};
  spec.exclusive = {{{"slam", {}}, names("LP GL")}};
  spec.order = names("GL local");
  spec.steal_off = names("GL");
  spec.scheduler.slack = 0.07;
  spec.scheduler.frames = graph::FrameMode::kFixed;
  spec.scheduler.percentile = 90.0;
  auto app = graph::build_app(spec);
  EXPECT_TRUE(app.ok()) << (app ? "" : app.error().message());
  return *app;
}

inline Header header() {
  Header header;
  header.scheduler = "catan";
  header.cpus = os::CpuSet{0, 2, 3};
  header.host = {"2026-01-02T03:04:05Z", "6.1", "A \"fast\" one", "performance", "tsc", 8, seconds{4}};
  header.real_time = true;
  header.slack = 0.06;
  header.stealing = false;
  header.started = at(seconds{100});
  header.warm_up = seconds{2};
  header.note = "slowdown 2.0; it's ü";
  return header;
}

// Two rounds of the robot's nodes from `start` on, numbers from `first` on: runs in the order a reader gives them.
inline std::vector<Run> runs(const graph::App& app, Nanos start, std::uint64_t first) {
  const auto id = [&](const char* name) { return *app.graph.find_node(name); };
  std::vector<Run> result;
  for (std::uint64_t i = 0; i < 2; ++i) {
    const std::uint64_t number = first + i;
    const TimePoint t = at(start + milliseconds{20 * i});
    result.push_back({id("scan"), number, t, t + milliseconds{1}, microseconds{900}, 0, true, {}});
    // These end together: what is consumed comes first.
    result.push_back({id("LM"),
                      number,
                      t + milliseconds{1},
                      t + milliseconds{4},
                      milliseconds{3},
                      0,
                      true,
                      {{id("scan"), number, number}}});
    result.push_back(
        {id("LP"), number, t + milliseconds{4}, t + milliseconds{4}, Nanos{0}, 0, true, {{id("LM"), number, number}}});
  }
  const TimePoint t = at(start + milliseconds{30});
  result.push_back(
      {id("GL"), (first + 1) / 2, t, t + milliseconds{9}, milliseconds{8}, 1, false, {{id("scan"), first, first + 1}}});
  result.back().wait = microseconds{700};
  result.back().on_cpu = 3;
  return result;
}

inline std::vector<Run> read_runs(const Reader& reader) {
  std::vector<Run> result;
  const auto done = reader.each_run([&](const Run& run) { result.push_back(run); });
  EXPECT_TRUE(done.ok()) << (done ? "" : done.error().message());
  return result;
}

inline std::unique_ptr<Writer> make(const std::string& path, const graph::App& app) {
  auto writer = Writer::create(path, app, header());
  EXPECT_TRUE(writer.ok()) << (writer ? "" : writer.error().message());
  return writer ? std::move(*writer) : nullptr;
}

inline Reader open(const std::string& path) {
  auto reader = Reader::open(path);
  EXPECT_TRUE(reader.ok()) << (reader ? "" : reader.error().message());
  return std::move(*reader);
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace ctn::record::test
