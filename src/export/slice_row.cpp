#include "export/slice_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ctn::exports {

SliceRow::SliceRow(TraceWriter& trace, std::string name, std::optional<Track> parent, std::size_t max_lanes,
                   std::optional<int> rank)
    : trace_(&trace), name_(std::move(name)), parent_(parent), max_lanes_(max_lanes), rank_(rank) {
  add_lane();
}

TraceWriter::Event SliceRow::add(TimePoint begin, TimePoint end, std::string_view name) {
  Lane& lane = make_room(begin, end);
  lane.open.push_back(end);
  lane.last = begin;
  return trace_->begin_slice(lane.track, begin, name);
}

void SliceRow::finish() {
  for (Lane& lane : lanes_) end_slices(lane, TimePoint::max());
}

// A lane that has room for the slice. If there is none: the last lane, with the slice cut to what it has room for.
SliceRow::Lane& SliceRow::make_room(TimePoint& begin, TimePoint& end) {
  for (Lane& lane : lanes_) {
    end_slices(lane, begin);
    if (begin >= lane.last && (lane.open.empty() || end <= lane.open.back())) return lane;
  }
  if (lanes_.size() < max_lanes_) {
    add_lane();
    return lanes_.back();
  }
  Lane& lane = lanes_.back();
  begin = std::max(begin, lane.last);
  end = std::max(begin, lane.open.empty() ? end : std::min(end, lane.open.back()));
  return lane;
}

void SliceRow::add_lane() {
  const std::size_t lane = lanes_.size();
  const std::string name = lane == 0 ? name_ : fmt::format("{} ({})", name_, lane + 1);
  const auto rank = rank_ ? std::optional(*rank_ + static_cast<int>(lane)) : std::nullopt;
  lanes_.push_back({trace_->add_track(name, parent_, rank), {}, {}});
}

void SliceRow::end_slices(Lane& lane, TimePoint until) {
  for (; !lane.open.empty() && lane.open.back() <= until; lane.open.pop_back()) {
    lane.last = lane.open.back();
    trace_->end_slice(lane.track, lane.last);
  }
}

}  // namespace ctn::exports
