// For tests of why responses are late: what happens to a small app is written down as a story, and analysed.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/testing/times.h"
#include "graph/build.h"
#include "graph/testing/spec_text.h"
#include "why/json.h"
#include "why/why.h"

namespace ctn::why {

// scan -> LM -> LP, one subchain, between two clocks of others, sky and lamp; map, a queue node, is fed by scan; hog
// has nothing to do with them. Bounds: 32 ms, with clocks 35.
inline graph::App robot() {
  graph::AppSpec spec =
      graph::spec_of({"scan", "LM", "LP", "map", "hog", "lamp", "sky"}, {"sky scan LM LP lamp", "scan map"});
  graph::node(spec, "map").input = graph::InputKind::kQueue;
  graph::node(spec, "lamp").external = true;
  graph::node(spec, "lamp").period = graph::At<Nanos>{ms(16), {}};
  graph::node(spec, "sky").external = true;
  graph::node(spec, "sky").period = graph::At<Nanos>{ms(20), {}};
  spec.subchains = {graph::subchain("local", "scan LM LP")};
  spec.objective = {graph::response("scan LM LP", 1.0), graph::period("map", 0.5), graph::response("scan map", 0.1),
                    graph::response("scan LM LP lamp", 0.1), graph::response("sky scan LM LP", 0.1)};
  spec.objective[0].max = graph::At<Nanos>{ms(32), {}};
  for (const std::size_t term : {3U, 4U}) spec.objective[term].max = graph::At<Nanos>{ms(35), {}};
  return graph::build_app(spec).value();
}

// A run, as a test writes it; times in ms.
struct Written {
  double begin = 0.0;
  double end = 0.0;
  double cpu = -1.0;  // as long as it took
  double wait = 0.0;
  bool emitted = true;
};

// What happened on one CPU, for the first chain unless another is asked for.
class Story {
 public:
  explicit Story(std::size_t term = 0, std::size_t cpus = 1)
      : app_(robot()), term_(term), cpus_(cpus), analyser_(app_, {term}, cpus, measured_) {}

  template <class One>
  auto add(const One& event) {
    events_.emplace_back(event);
    return analyser_.add(event);
  }

  NodeId id(const std::string& name) const { return *app_.graph.find_node(name); }
  void trigger(double due, double sent) {
    const auto number = ++triggers_;
    add(record::Trigger{SubchainId{0}, number, at(ms(due)), at(ms(sent))});
  }
  // It took what the node before it in the subchain gave last.
  void run(const std::string& name, const Written& written) {
    static const std::map<std::string, std::string> kBefore{{"LM", "scan"}, {"LP", "LM"}, {"map", "scan"}};
    record::Run run;
    run.node = id(name);
    run.number = ++count_[name];
    run.begin = at(ms(written.begin));
    run.end = at(ms(written.end));
    run.cpu = ms(written.cpu >= 0.0 ? written.cpu : written.end - written.begin - written.wait);
    run.wait = ms(written.wait);
    run.emitted = written.emitted;
    if (kBefore.contains(name)) {
      const std::string& before = kBefore.at(name);
      const std::uint64_t first = name == "map" ? taken_[name] + 1 : given_[before];
      if (given_[before] >= first && given_[before] > 0) {
        run.consumed.push_back({id(before), first, given_[before]});
        taken_[name] = given_[before];
      }
    }
    if (written.emitted) given_[name] = run.number;
    add(run);
  }
  // scan 2, LM 3, LP 4, from a trigger at `t` on, which was due then or sooner.
  void round(double t) { round(t, t); }
  void round(double due, double t) {
    trigger(due, t);
    run("scan", {t, t + 2});
    run("LM", {t + 2, t + 5});
    run("LP", {t + 5, t + 9});
  }
  void rounds(double from, int count) {
    for (int i = 0; i < count; ++i) round(from + 20.0 * i);
  }
  void clock(const std::string& name, double tick, double period) {
    add(record::ClockReading{at(Nanos{0}), id(name), {at(ms(tick)), ms(period)}});
  }
  // From then on.
  void clock(const std::string& name, double from, double tick, double period) {
    add(record::ClockReading{at(ms(from)), id(name), {at(ms(tick)), ms(period)}});
  }

  // Also checks that it comes to the same if it is analysed while it happens, and forgotten.
  Analysis finish(std::size_t worst = 1000) {
    sort_events();
    Analyser at_once(app_, {term_}, cpus_, measured_);
    for (const Event& event : events_) std::visit([&](const auto& one) { tell(at_once, one); }, event);
    const std::string expected = to_json(at_once.finish(worst).front(), app_, measured_.begin);
    for (const std::size_t step : {1U, 3U, 20U}) {
      EXPECT_EQ(to_json(meanwhile(worst, step), app_, measured_.begin), expected) << step;
    }
    return analyser_.finish(worst).front();
  }
  // "running scan 2" of all parts of the longest response.
  std::vector<std::string> longest() {
    const Analysis analysis = finish(1);
    std::vector<std::string> parts;
    if (analysis.worst.empty()) return parts;
    for (const Part& part : analysis.worst.front().parts) {
      const std::string by = part.by ? " by " + app_.graph.node(*part.by).name : "";
      parts.push_back(std::string(to_string(part.kind)) + " " + app_.graph.node(part.node).name + by + " " +
                      nlohmann::json(to_millis(part.length()).count()).dump());
    }
    cause_ = analysis.worst.front().cause;
    return parts;
  }
  // Of the longest; after longest().
  std::string cause() const {
    if (!cause_) return "none";
    return std::string(to_string(cause_->kind)) + " " + app_.graph.node(cause_->node).name +
           (cause_->by ? " by " + app_.graph.node(*cause_->by).name : "");
  }
  const graph::App& app() const { return app_; }
  Analyser& analyser() { return analyser_; }

 private:
  using Event = std::variant<record::Trigger, record::SlotUse, record::Steal, record::PlanChange, record::ClockReading,
                             record::Run>;

  template <class One>
  static void tell(Analyser& analyser, const One& one) {
    if constexpr (std::is_same_v<One, record::PlanChange>) {
      static_cast<void>(analyser.add(one));  // a plan that cannot be read is passed over
    } else {
      analyser.add(one);
    }
  }
  // As a record has them: runs and readings after all others, by time.
  void sort_events() {
    const auto time_of = [](const Event& event) {
      if (const auto* const run = std::get_if<record::Run>(&event)) return run->end;
      const auto* const reading = std::get_if<record::ClockReading>(&event);
      return reading != nullptr ? reading->at : TimePoint::min();
    };
    std::stable_sort(events_.begin(), events_.end(),
                     [&](const Event& a, const Event& b) { return time_of(a) < time_of(b); });
  }
  Analysis meanwhile(std::size_t worst, std::size_t step) const {
    Survey survey(app_, {term_}, measured_);
    for (const Event& event : events_) {
      if (const auto* const run = std::get_if<record::Run>(&event)) survey.add(*run);
      if (const auto* const reading = std::get_if<record::ClockReading>(&event)) survey.add(*reading);
    }
    survey.finish();
    Analyser analyser(app_, {term_}, cpus_, measured_);
    analyser.analyse_meanwhile(survey, worst, step);
    for (const Event& event : events_) std::visit([&](const auto& one) { tell(analyser, one); }, event);
    return analyser.finish().front();
  }

  graph::App app_;
  std::size_t term_;
  std::size_t cpus_;
  record::Interval measured_{at(Nanos{0})};
  Analyser analyser_;
  std::vector<Event> events_;
  std::uint64_t triggers_ = 0;
  std::map<std::string, std::uint64_t> count_;
  std::map<std::string, std::uint64_t> given_;
  std::map<std::string, std::uint64_t> taken_;
  std::optional<Cause> cause_;
};

}  // namespace ctn::why
