// A record is written as a trace, and read back as Perfetto reads it: by track and time.
#include "export/perfetto.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <variant>

#include "export/testing/samples.h"
#include "export/trace.pb.h"

namespace ctn::exports {
namespace {

using namespace test;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr std::int64_t kMs = 1'000'000;

using Value = std::variant<bool, std::uint64_t, double, std::string>;

struct Slice {
  std::string name;
  std::int64_t begin = 0;
  std::int64_t end = -1;
  std::size_t depth = 0;
  std::map<std::string, Value> arguments;
};
struct Count {
  std::int64_t at = 0;
  double value = 0.0;
  friend bool operator==(const Count&, const Count&) = default;
};
struct TrackView {
  std::string path;  // the names from the root on, without the root's own
  std::vector<Slice> slices;
  std::vector<Slice> instants;
  std::vector<Count> counts;
  bool is_counter = false;
  bool nests = true;  // each end belongs to a begin, and the other way round
};

// A whole trace, taken apart.
class TraceView {
 public:
  explicit TraceView(const std::string& bytes) {
    proto::Trace trace;
    EXPECT_TRUE(trace.ParseFromString(bytes));
    EXPECT_TRUE(trace.unknown_fields().empty());
    packets = static_cast<std::size_t>(trace.packet_size());
    for (const proto::TracePacket& packet : trace.packet()) read(packet);
    for (auto& [track, events] : events_) {
      std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
      replay(tracks_.at(track), events);
    }
  }

  const TrackView& track(const std::string& path) const {
    static const TrackView kNone;
    const TrackView* found = nullptr;
    for (const auto& [uuid, track] : tracks_) {
      if (track.path != path) continue;
      EXPECT_EQ(found, nullptr) << "several tracks are " << path;
      found = &track;
    }
    EXPECT_NE(found, nullptr) << "no track is " << path;
    return found == nullptr ? kNone : *found;
  }
  std::vector<const TrackView*> tracks() const {
    std::vector<const TrackView*> all;
    for (const auto& [uuid, track] : tracks_) all.push_back(&track);
    return all;
  }

  std::size_t packets = 0;
  // Of the first packet.
  std::uint32_t clock = 0;
  std::uint32_t primary_clock = 0;
  std::uint64_t clock_at = 0;
  // Which slices they begin and end at: track and number of the run.
  std::map<std::uint64_t, std::string> flow_begins;
  std::map<std::uint64_t, std::string> flow_ends;
  bool flows_are_unique = true;
  bool in_order = true;  // of each track

 private:
  struct Event {
    std::int64_t at;
    proto::TrackEvent event;
    Slice slice;
  };

  void read(const proto::TracePacket& packet) {
    EXPECT_EQ(packet.trusted_packet_sequence_id(), 1U);
    if (packet.has_clock_snapshot()) {
      EXPECT_EQ(packet.sequence_flags(), proto::TracePacket::SEQ_INCREMENTAL_STATE_CLEARED);
      clock = packet.trace_packet_defaults().timestamp_clock_id();
      primary_clock = static_cast<std::uint32_t>(packet.clock_snapshot().primary_trace_clock());
      clock_at = packet.clock_snapshot().clocks(0).timestamp();
    }
    for (const auto& name : packet.interned_data().event_names()) names_[name.iid()] = name.name();
    for (const auto& word : packet.interned_data().debug_annotation_string_values()) words_[word.iid()] = word.name();
    for (const auto& name : packet.interned_data().debug_annotation_names()) arguments_[name.iid()] = name.name();
    if (packet.has_track_descriptor()) read(packet.track_descriptor());
    if (packet.has_track_event()) {
      EXPECT_EQ(packet.sequence_flags(), proto::TracePacket::SEQ_NEEDS_INCREMENTAL_STATE);
      read(packet.track_event(), static_cast<std::int64_t>(packet.timestamp()));
    }
  }

  void read(const proto::TrackDescriptor& descriptor) {
    EXPECT_FALSE(tracks_.contains(descriptor.uuid()));
    TrackView& track = tracks_[descriptor.uuid()];
    track.is_counter = descriptor.has_counter();
    if (!descriptor.has_parent_uuid()) return;
    const std::string& parent = tracks_.at(descriptor.parent_uuid()).path;
    track.path = parent.empty() ? descriptor.name() : parent + "/" + descriptor.name();
  }

  void read(const proto::TrackEvent& event, std::int64_t at) {
    Slice slice;
    slice.begin = at;
    if (event.has_name_iid()) slice.name = names_.at(event.name_iid());
    for (const proto::DebugAnnotation& argument : event.debug_annotations()) {
      slice.arguments[arguments_.at(argument.name_iid())] = value_of(argument);
    }
    std::vector<Event>& events = events_[event.track_uuid()];
    in_order =
        in_order && (events.empty() || events.back().at <= at || event.type() == proto::TrackEvent::TYPE_INSTANT);
    const std::string run = tracks_.at(event.track_uuid()).path + "#" +
                            (slice.arguments.contains("number") && event.type() == proto::TrackEvent::TYPE_SLICE_BEGIN
                                 ? std::to_string(std::get<std::uint64_t>(slice.arguments.at("number")))
                                 : "");
    for (const std::uint64_t id : event.flow_ids()) flows_are_unique &= flow_begins.emplace(id, run).second;
    for (const std::uint64_t id : event.terminating_flow_ids()) flows_are_unique &= flow_ends.emplace(id, run).second;
    events.push_back({at, event, slice});
  }

  Value value_of(const proto::DebugAnnotation& argument) const {
    if (argument.has_string_value_iid()) return words_.at(argument.string_value_iid());
    if (argument.has_bool_value()) return argument.bool_value();
    if (argument.has_uint_value()) return argument.uint_value();
    if (argument.has_double_value()) return argument.double_value();
    return argument.string_value();
  }

  static void replay(TrackView& track, const std::vector<Event>& events) {
    std::vector<std::size_t> open;
    for (const Event& event : events) {
      switch (event.event.type()) {
        case proto::TrackEvent::TYPE_SLICE_BEGIN:
          track.slices.push_back(event.slice);
          track.slices.back().depth = open.size();
          open.push_back(track.slices.size() - 1);
          break;
        case proto::TrackEvent::TYPE_SLICE_END:
          track.nests = track.nests && !open.empty();
          if (open.empty()) break;
          track.slices[open.back()].end = event.at;
          open.pop_back();
          break;
        case proto::TrackEvent::TYPE_INSTANT:
          track.instants.push_back(event.slice);
          break;
        default:
          track.counts.push_back({event.at, event.event.double_counter_value()});
      }
    }
    track.nests = track.nests && open.empty();
  }

  std::map<std::uint64_t, TrackView> tracks_;
  std::map<std::uint64_t, std::vector<Event>> events_;
  std::map<std::uint64_t, std::string> names_;
  std::map<std::uint64_t, std::string> arguments_;
  std::map<std::uint64_t, std::string> words_;
};

class PerfettoTest : public testing::Test {
 protected:
  template <class Add>
  TraceView trace_of(Add add, bool complete = true) {
    const std::string path = folder_.file("r");
    const auto writer = make(path, app_);
    add(*writer, app_);
    EXPECT_TRUE((complete ? writer->close(at(seconds{110}), header().host) : writer->flush()).ok());
    std::string bytes;
    const Status done = write_perfetto(open(path), into(bytes), [](double part) { EXPECT_LE(part, 1.0); });
    EXPECT_TRUE(done.ok()) << (done ? "" : done.error().message());
    return TraceView(bytes);
  }

  static void expect_sound(const TraceView& trace) {
    EXPECT_TRUE(trace.in_order);
    for (const TrackView* track : trace.tracks()) {
      EXPECT_TRUE(track->nests) << track->path;
      EXPECT_TRUE(!track->is_counter || track->slices.empty()) << track->path;
      EXPECT_TRUE(track->is_counter || track->counts.empty()) << track->path;
    }
  }

  Folder folder_;
  graph::App app_ = robot();
};

auto is_slice(const std::string& name, std::int64_t begin, std::int64_t end) {
  return AllOf(testing::Field(&Slice::name, name), testing::Field(&Slice::begin, begin),
               testing::Field(&Slice::end, end));
}

TEST_F(PerfettoTest, RunsAreSlicesOfTheirNodesBelowTheirSubchain) {
  const TraceView trace = trace_of(add_sample);
  expect_sound(trace);
  const std::int64_t t = 103'000 * kMs;
  EXPECT_THAT(trace.track("subchains/local/scan").slices,
              ElementsAre(is_slice("scan", t, t + kMs), is_slice("scan", t + 20 * kMs, t + 21 * kMs)));
  EXPECT_THAT(trace.track("subchains/local/LP").slices,
              ElementsAre(is_slice("LP", t + 4 * kMs, t + 4 * kMs), is_slice("LP", t + 24 * kMs, t + 24 * kMs)));
  const TrackView& queue = trace.track("subchains/GL/GL");
  ASSERT_THAT(queue.slices, ElementsAre(is_slice("GL", t + 30 * kMs, t + 39 * kMs)));
  const std::map<std::string, Value> expected{{"number", std::uint64_t{1}}, {"cpu_ms", 8.0},
                                              {"on_cpu", std::uint64_t{3}}, {"wait_ms", 0.7},
                                              {"emitted", false},           {"mode", std::string("match")}};
  EXPECT_EQ(queue.slices[0].arguments, expected);
  EXPECT_TRUE(trace.track("unscheduled nodes/imu").slices.empty());
}

TEST_F(PerfettoTest, TimesAreOfTheMonotonicClock) {
  const TraceView trace = trace_of(add_sample);
  EXPECT_EQ(trace.clock, 3U);
  EXPECT_EQ(trace.primary_clock, 3U);
  EXPECT_EQ(trace.clock_at, 100'000U * kMs);
}

TEST_F(PerfettoTest, AFlowLeadsFromEachRunToEachThatConsumedIt) {
  const TraceView trace = trace_of(add_sample);
  EXPECT_TRUE(trace.flows_are_unique);
  std::vector<std::string> arrows;
  for (const auto& [id, from] : trace.flow_begins) {
    ASSERT_TRUE(trace.flow_ends.contains(id)) << from;
    arrows.push_back(from + " > " + trace.flow_ends.at(id));
  }
  EXPECT_EQ(trace.flow_ends.size(), arrows.size());
  EXPECT_THAT(arrows,
              UnorderedElementsAre(
                  "subchains/local/scan#1 > subchains/local/LM#1", "subchains/local/scan#2 > subchains/local/LM#2",
                  "subchains/local/LM#1 > subchains/local/LP#1", "subchains/local/LM#2 > subchains/local/LP#2",
                  "subchains/local/scan#1 > subchains/GL/GL#1", "subchains/local/scan#2 > subchains/GL/GL#1"));
}

// An input that is *latest* may be taken by several runs: an arrow to each of them.
TEST_F(PerfettoTest, ARunThatIsConsumedAgainHasOneMoreFlow) {
  const TraceView trace = trace_of([](record::Writer& writer, const graph::App& app) {
    const NodeId from = *app.graph.find_node("GL");
    const NodeId to = *app.graph.find_node("LP");
    writer.add(record::Run{from, 1, at_ms(100'100), at_ms(100'110), milliseconds{1}, 0, true, {}});
    for (std::uint64_t i = 1; i < 4; ++i) {
      const TimePoint begin = at_ms(100'110) + milliseconds{i};
      writer.add(record::Run{to, i, begin, begin, Nanos{0}, 0, true, {{from, 1, 1}}});
    }
  });
  expect_sound(trace);
  EXPECT_TRUE(trace.flows_are_unique);
  EXPECT_EQ(trace.flow_begins.size(), 3U);
  for (const auto& [id, from] : trace.flow_begins) EXPECT_EQ(trace.flow_ends.count(id), 1U);
}

TEST_F(PerfettoTest, CoresShowSlotsStealsAndWhoHadThemAlone) {
  const TraceView trace = trace_of(add_sample);
  const std::int64_t t = 103'000 * kMs;
  ASSERT_THAT(trace.track("cores/core 1: slots").slices, ElementsAre(is_slice("GL", t + 30 * kMs, t + 40 * kMs)));
  EXPECT_EQ(trace.track("cores/core 1: slots").slices[0].arguments.at("late_ms"), Value(1.0));
  ASSERT_THAT(trace.track("cores/core 1: stolen").slices, ElementsAre(is_slice("local", t + 28 * kMs, t + 30 * kMs)));
  EXPECT_EQ(trace.track("cores/core 1: stolen").slices[0].arguments.at("from"), Value("GL"));
  EXPECT_THAT(trace.track("cores/core 0: runs").slices,
              ElementsAre(is_slice("scan", t, t + kMs), is_slice("LM", t + kMs, t + 4 * kMs),
                          is_slice("LP", t + 4 * kMs, t + 4 * kMs), is_slice("scan", t + 20 * kMs, t + 21 * kMs),
                          is_slice("LM", t + 21 * kMs, t + 24 * kMs), is_slice("LP", t + 24 * kMs, t + 24 * kMs)));
}

TEST_F(PerfettoTest, ARunThatPreEmptsAnotherIsInIt) {
  const TraceView trace = trace_of([](record::Writer& writer, const graph::App& app) {
    writer.add(record::PlanChange{at(seconds{100}), "static", plan_json(app, 10.0)});
    const auto add = [&](const char* node, int begin, int end) {
      writer.add(record::Run{*app.graph.find_node(node), 1, at_ms(begin), at_ms(end), Nanos{1}, 0, true, {}});
    };
    add("scan", 101'000, 101'010);
    add("LM", 101'002, 101'004);
    add("LP", 101'005, 101'012);  // runs while the first one waits
  });
  expect_sound(trace);
  const TrackView& core = trace.track("cores/core 0: runs");
  ASSERT_EQ(core.slices.size(), 2U);
  EXPECT_EQ(core.slices[1].depth, 1U);
  EXPECT_THAT(trace.track("cores/core 0: runs (2)").slices, ElementsAre(is_slice("LP", 101'005 * kMs, 101'012 * kMs)));
}

TEST_F(PerfettoTest, TriggersOverrunsPlansChangesAndNotices) {
  const TraceView trace = trace_of(add_sample);
  const std::int64_t t = 103'000 * kMs;
  const TrackView& subchain = trace.track("subchains/local");
  EXPECT_THAT(subchain.slices, ElementsAre(is_slice("trigger", t, t + kMs / 4),
                                           is_slice("trigger", t + 20 * kMs, t + 20 * kMs + kMs / 4)));
  ASSERT_EQ(subchain.instants.size(), 1U);
  EXPECT_EQ(subchain.instants[0].name, "overrun");
  EXPECT_EQ(subchain.instants[0].arguments.at("cpu_ms"), Value(2.5));
  EXPECT_THAT(trace.track("plans").slices, ElementsAre(is_slice("bootstrap", 100'000 * kMs, 102'000 * kMs),
                                                       is_slice("measured", 102'000 * kMs, 110'000 * kMs)));
  EXPECT_EQ(trace.track("plans").slices[1].arguments.at("objective_ms"), Value(100.0));
  EXPECT_EQ(trace.track("changes").instants.size(), 2U);
  ASSERT_EQ(trace.track("notices").instants.size(), 1U);
  EXPECT_EQ(trace.track("notices").instants[0].name, "watchdog");
  EXPECT_EQ(trace.track("notices").instants[0].arguments.at("detail"),
            Value("a,\"b\"\xEF\xBF\xBD <c>\xEF\xBF\xBD\xEF\xBF\xBD"));
}

TEST_F(PerfettoTest, CountersShowWhatWasMeasuredBesideWhatWasPlanned) {
  const TraceView trace = trace_of(add_sample);
  const std::string chain = "response times/scan -> LM -> LP -> base/";
  const auto counts = [&](const std::string& path) { return trace.track(path).counts; };
  EXPECT_THAT(counts(chain + "measured"), ElementsAre(Count{103'024 * kMs, 24.0}));
  EXPECT_THAT(counts(chain + "promised"), ElementsAre(Count{100'000 * kMs, 150.0}, Count{102'000 * kMs, 30.0}));
  EXPECT_THAT(counts(chain + "expected"), ElementsAre(Count{100'000 * kMs, 150.0}, Count{102'000 * kMs, 30.0}));
  EXPECT_THAT(counts(chain + "bound"), ElementsAre(Count{100'000 * kMs, 60.0}, Count{105'000 * kMs, 40.5}));
  EXPECT_THAT(counts("compute times/local/LM"), ElementsAre(Count{103'004 * kMs, 3.0}, Count{103'024 * kMs, 3.0}));
  EXPECT_THAT(counts("compute times/local/measured"),
              ElementsAre(Count{103'004 * kMs, 3.9}, Count{103'024 * kMs, 3.9}));
  EXPECT_THAT(counts("compute times/local/planned"),
              ElementsAre(Count{100'000 * kMs, 50.0}, Count{102'000 * kMs, 10.0}));
}

TEST_F(PerfettoTest, AnEmptyRecordIsATraceWithTracks) {
  const TraceView trace = trace_of([](record::Writer&, const graph::App&) {});
  expect_sound(trace);
  for (const TrackView* track : trace.tracks()) EXPECT_TRUE(track->path.empty() || track->slices.empty());
  EXPECT_TRUE(trace.track("subchains/local").instants.empty());
}

TEST_F(PerfettoTest, ARecordThatIsStillWrittenEndsWithItsLastEvent) {
  const TraceView trace = trace_of(add_sample, false);
  expect_sound(trace);
  EXPECT_EQ(trace.track("plans").slices.back().end, 106'000 * kMs);
}

TEST_F(PerfettoTest, ARecordThatWasTamperedWithIsATraceAllTheSame) {
  const TraceView trace = trace_of(add_nonsense);
  expect_sound(trace);
  EXPECT_EQ(trace.track("subchains/GL/GL").slices.size(), 29U);
  EXPECT_EQ(trace.track("subchains/GL/GL").slices[0].arguments.at("mode"), Value("77"));
}

TEST_F(PerfettoTest, NamesAreWrittenOnce) {
  const auto size = [&](int runs_of_scan) {
    const std::string path = folder_.file(std::to_string(runs_of_scan));
    const auto writer = make(path, app_);
    for (std::uint64_t i = 1; i <= static_cast<std::uint64_t>(runs_of_scan); ++i) {
      const TimePoint begin = at(seconds{100} + milliseconds{i});
      writer->add(record::Run{*app_.graph.find_node("scan"), i, begin, begin, Nanos{0}, 0, true, {}});
    }
    EXPECT_TRUE(writer->close(at(seconds{110}), header().host).ok());
    std::string bytes;
    EXPECT_TRUE(write_perfetto(open(path), into(bytes), [](double) {}).ok());
    return bytes.size();
  };
  EXPECT_LT((size(3000) - size(1000)) / 2000, 150U);
}

TEST_F(PerfettoTest, TheFirstFailureOfTheSinkIsTold) {
  const std::string path = folder_.file("r");
  const auto writer = make(path, app_);
  add_sample(*writer, app_);
  ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  int calls = 0;
  const Sink full = [&](std::string_view) -> Status {
    ++calls;
    return Error::environment("the disk is full", "make room");
  };
  const Status done = write_perfetto(open(path), full, [](double) {});
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().message(), "the disk is full; make room");
  EXPECT_EQ(calls, 1);
}

TEST_F(PerfettoTest, APlanThatCannotBeReadIsTold) {
  const std::string path = folder_.file("r");
  const auto writer = make(path, app_);
  writer->add(record::PlanChange{at(seconds{100}), "static", "{}"});
  ASSERT_TRUE(writer->close(at(seconds{110}), header().host).ok());
  std::string bytes;
  const Status done = write_perfetto(open(path), into(bytes), [](double) {});
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().kind(), ErrorKind::kCaller);
  EXPECT_THAT(done.error().message(), testing::HasSubstr("plan 1 of the record"));
}

}  // namespace
}  // namespace ctn::exports
