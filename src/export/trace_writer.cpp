#include "export/trace_writer.h"

#include <utility>

#include "export/trace.pb.h"
#include "report/escape.h"

namespace ctn::exports {

struct TraceWriter::Batch {
  proto::Trace trace;
  proto::TracePacket* packet = nullptr;  // the last one
  std::string bytes;

  // The number of a name, which the packet brings with it if it is new.
  std::uint64_t number_of(std::string_view name, Names& names,
                          proto::InternedName* (proto::InternedData::*add)()) const {
    const auto known = names.find(name);
    if (known != names.end()) return known->second;
    const std::uint64_t number = names.emplace(name, names.size() + 1).first->second;
    proto::InternedName* const entry = (packet->mutable_interned_data()->*add)();
    entry->set_iid(number);
    entry->set_name(report::cleaned(name));
    return number;
  }
  proto::DebugAnnotation& annotate(std::string_view name, Names& names) const {
    const std::uint64_t number = number_of(name, names, &proto::InternedData::add_debug_annotation_names);
    proto::DebugAnnotation* const annotation = packet->mutable_track_event()->add_debug_annotations();
    annotation->set_name_iid(number);
    return *annotation;
  }
};

TraceWriter::Event& TraceWriter::Event::number(std::string_view name, std::uint64_t value) {
  writer_->batch_->annotate(name, writer_->annotations_).set_uint_value(value);
  return *this;
}

TraceWriter::Event& TraceWriter::Event::real(std::string_view name, double value) {
  writer_->batch_->annotate(name, writer_->annotations_).set_double_value(value);
  return *this;
}

TraceWriter::Event& TraceWriter::Event::flag(std::string_view name, bool value) {
  writer_->batch_->annotate(name, writer_->annotations_).set_bool_value(value);
  return *this;
}

TraceWriter::Event& TraceWriter::Event::text(std::string_view name, std::string_view value) {
  writer_->batch_->annotate(name, writer_->annotations_).set_string_value(report::cleaned(value));
  return *this;
}

TraceWriter::Event& TraceWriter::Event::word(std::string_view name, std::string_view value) {
  Batch& batch = *writer_->batch_;
  const auto number = batch.number_of(value, writer_->words_, &proto::InternedData::add_debug_annotation_string_values);
  batch.annotate(name, writer_->annotations_).set_string_value_iid(number);
  return *this;
}

TraceWriter::Event& TraceWriter::Event::begin_flow(std::uint64_t id) {
  writer_->batch_->packet->mutable_track_event()->add_flow_ids(id);
  return *this;
}

TraceWriter::Event& TraceWriter::Event::end_flow(std::uint64_t id) {
  writer_->batch_->packet->mutable_track_event()->add_terminating_flow_ids(id);
  return *this;
}

TraceWriter::TraceWriter(Sink sink, TimePoint started) : sink_(std::move(sink)), batch_(std::make_unique<Batch>()) {
  next_packet();
  proto::TracePacket& packet = *batch_->packet;
  packet.set_sequence_flags(proto::TracePacket::SEQ_INCREMENTAL_STATE_CLEARED);
  packet.mutable_trace_packet_defaults()->set_timestamp_clock_id(proto::BUILTIN_CLOCK_MONOTONIC);
  proto::ClockSnapshot& snapshot = *packet.mutable_clock_snapshot();
  snapshot.set_primary_trace_clock(proto::BUILTIN_CLOCK_MONOTONIC);
  proto::ClockSnapshot::Clock& clock = *snapshot.add_clocks();
  clock.set_clock_id(proto::BUILTIN_CLOCK_MONOTONIC);
  clock.set_timestamp(static_cast<std::uint64_t>(started.time_since_epoch().count()));
}

TraceWriter::~TraceWriter() = default;

Track TraceWriter::add_track(std::string_view name, std::optional<Track> parent, std::optional<int> rank) {
  next_packet();
  proto::TrackDescriptor& track = *batch_->packet->mutable_track_descriptor();
  track.set_uuid(++tracks_);
  track.set_name(report::cleaned(name));
  if (parent) track.set_parent_uuid(static_cast<std::uint64_t>(*parent));
  track.set_child_ordering(proto::TrackDescriptor::EXPLICIT);
  track.set_sibling_order_rank(rank.value_or(static_cast<int>(tracks_)));
  return Track{tracks_};
}

Track TraceWriter::add_counter(std::string_view name, Track parent) {
  const Track track = add_track(name, parent);
  proto::CounterDescriptor& counter = *batch_->packet->mutable_track_descriptor()->mutable_counter();
  counter.set_unit_name("ms");
  counter.set_y_axis_share_key("ms");
  return track;
}

TraceWriter::Event TraceWriter::begin_slice(Track track, TimePoint at, std::string_view name) {
  next_event(proto::TrackEvent::TYPE_SLICE_BEGIN, track, at);
  set_name(name);
  return Event(*this);
}

void TraceWriter::end_slice(Track track, TimePoint at) { next_event(proto::TrackEvent::TYPE_SLICE_END, track, at); }

TraceWriter::Event TraceWriter::add_instant(Track track, TimePoint at, std::string_view name) {
  next_event(proto::TrackEvent::TYPE_INSTANT, track, at);
  set_name(name);
  return Event(*this);
}

void TraceWriter::add_count(Track track, TimePoint at, double value) {
  next_event(proto::TrackEvent::TYPE_COUNTER, track, at);
  batch_->packet->mutable_track_event()->set_double_counter_value(value);
}

Status TraceWriter::finish() {
  flush();
  return status_;
}

void TraceWriter::next_packet() {
  if (batch_->trace.packet_size() == kBatch) flush();
  batch_->packet = batch_->trace.add_packet();
  batch_->packet->set_trusted_packet_sequence_id(1);
}

void TraceWriter::next_event(int type, Track track, TimePoint at) {
  next_packet();
  batch_->packet->set_sequence_flags(proto::TracePacket::SEQ_NEEDS_INCREMENTAL_STATE);
  batch_->packet->set_timestamp(static_cast<std::uint64_t>(at.time_since_epoch().count()));
  proto::TrackEvent& event = *batch_->packet->mutable_track_event();
  event.set_type(static_cast<proto::TrackEvent::Type>(type));
  event.set_track_uuid(static_cast<std::uint64_t>(track));
}

void TraceWriter::set_name(std::string_view name) {
  const std::uint64_t number = batch_->number_of(name, events_, &proto::InternedData::add_event_names);
  batch_->packet->mutable_track_event()->set_name_iid(number);
}

// Perfetto reads traces that follow one another as one trace.
void TraceWriter::flush() {
  if (status_ && batch_->trace.packet_size() > 0) {
    batch_->trace.SerializeToString(&batch_->bytes);
    status_ = sink_(batch_->bytes);
  }
  batch_->trace.Clear();
}

}  // namespace ctn::exports
