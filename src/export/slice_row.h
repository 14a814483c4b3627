// A row of slices in which all slices nest: Perfetto requires that a slice which begins in another one of its track
// also ends in that one. A slice that would not is put onto a further lane of the row, which is a track of its own.
//
// Slices are added in the order of their begins. A slice that no lane has room for, or that comes out of order, as in a
// record that was tampered with, is cut to fit.
//
// Thread safety: none; one owner. Memory: open slices.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time.h"
#include "export/trace_writer.h"

namespace ctn::exports {

class SliceRow {
 public:
  // `trace` outlives it. Lanes are next to one another in rank.
  SliceRow(TraceWriter& trace, std::string name, std::optional<Track> parent, std::size_t max_lanes = 1,
           std::optional<int> rank = std::nullopt);

  // Precondition: begin <= end.
  TraceWriter::Event add(TimePoint begin, TimePoint end, std::string_view name);
  // Ends what is open; nothing is added after that.
  void finish();

  Track track() const { return lanes_.front().track; }  // of the first lane

 private:
  struct Lane {
    Track track{};
    std::vector<TimePoint> open;  // ends of slices, the innermost last
    TimePoint last{};             // the last instant that was written
  };

  void add_lane();
  void end_slices(Lane& lane, TimePoint until);
  Lane& make_room(TimePoint& begin, TimePoint& end);

  TraceWriter* trace_;
  std::string name_;
  std::optional<Track> parent_;
  std::size_t max_lanes_;
  std::optional<int> rank_;
  std::vector<Lane> lanes_;
};

}  // namespace ctn::exports
