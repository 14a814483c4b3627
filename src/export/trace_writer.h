// Writes a trace of Perfetto, packet by packet: tracks, and what happens on them. Names are written once and referred
// to by number. Packets of different tracks may come in any order; Perfetto sorts them by time. Times are of the
// monotonic clock, and the trace says so.
//
// Texts need not be trusted: control characters and what is not UTF-8 are replaced.
//
// Thread safety: none; one owner. Memory: packets that are not written yet (kBatch), and the names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "base/time.h"
#include "export/output.h"

namespace ctn::exports {

enum class Track : std::uint64_t {};

class TraceWriter {
 public:
  // Adds arguments to an event. Valid until the next event is added.
  class Event {
   public:
    Event& number(std::string_view name, std::uint64_t value);
    Event& real(std::string_view name, double value);
    Event& ms(std::string_view name, Nanos value) { return real(name, to_millis(value).count()); }
    Event& flag(std::string_view name, bool value);
    Event& text(std::string_view name, std::string_view value);
    // A text of which there are few different ones: each is written once.
    Event& word(std::string_view name, std::string_view value);
    // An arrow from the event that begins a flow to the one that ends it. Ids are unique in the trace.
    Event& begin_flow(std::uint64_t id);
    Event& end_flow(std::uint64_t id);

   private:
    friend class TraceWriter;
    explicit Event(TraceWriter& writer) : writer_(&writer) {}
    TraceWriter* writer_;
  };

  TraceWriter(Sink sink, TimePoint started);
  ~TraceWriter();
  TraceWriter(const TraceWriter&) = delete;
  TraceWriter& operator=(const TraceWriter&) = delete;

  // Tracks stand below their parent, in the order of ranks or, without ranks, in the order in which they are added.
  Track add_track(std::string_view name, std::optional<Track> parent, std::optional<int> rank = std::nullopt);
  // A counter in milliseconds. Counters of one parent share a scale.
  Track add_counter(std::string_view name, Track parent);

  // Slices of a track nest, and begin and end in the order of time (slice_row.h).
  Event begin_slice(Track track, TimePoint at, std::string_view name);
  void end_slice(Track track, TimePoint at);
  Event add_instant(Track track, TimePoint at, std::string_view name);
  void add_count(Track track, TimePoint at, double value);

  // Writes what is left. Returns the first failure of the sink, after which nothing was written.
  Status finish();

 private:
  static constexpr int kBatch = 1024;
  struct Batch;
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;  // NOLINT(readability-identifier-naming)
  };
  using Names = std::unordered_map<std::string, std::uint64_t, Hash, std::equal_to<>>;

  void next_packet();
  void next_event(int type, Track track, TimePoint at);
  void set_name(std::string_view name);
  void flush();

  Sink sink_;
  Status status_ = Done{};
  std::unique_ptr<Batch> batch_;
  std::uint64_t tracks_ = 0;
  Names events_;
  Names annotations_;
  Names words_;
};

}  // namespace ctn::exports
