#include "flight/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "flight/event_words.h"
#include "flight/layout.h"
#include "os/linux/shared_memory.h"
#include "record/reader.h"

namespace ctn::flight {
namespace {

Error no_recording(const std::string& why) {
  return Error::environment("this is not the memory of a flight recorder: " + why,
                            "use the same version of Catan for both programs");
}

// Writes events to a record as they come, and finds out when the first and the last of them happened. Events that hold
// until they are replaced may be older than all others: they are kept, each once, and written at the end, as of the
// record's start if they are older.
class Saver : public record::ForwardingSink {
 public:
  explicit Saver(record::Writer& to) : ForwardingSink({&to}) {}

  using ForwardingSink::add;
  void add(const record::Run& run) override { put(run, run.begin, run.end); }
  void add(const record::Trigger& trigger) override { put(trigger, trigger.sent, trigger.sent); }
  void add(const record::SlotUse& slot) override { put(slot, slot.begin, slot.end); }
  void add(const record::Steal& steal) override { put(steal, steal.begin, steal.end); }
  void add(const record::Overrun& overrun) override { put(overrun, overrun.at, overrun.at); }
  void add(const record::CostChange& change) override { put(change, change.at, change.at); }
  void add(const record::Notice& notice) override { put(notice, notice.at, notice.at); }
  void add(const record::PlanChange& change) override { keep(plans_, change); }
  void add(const record::AppChange& change) override { keep(app_changes_, change); }
  void add(const record::ClockReading& reading) override { keep(clocks_, reading); }

  std::optional<TimePoint> first() const { return first_; }
  TimePoint last_or(TimePoint otherwise) const { return std::max(last_, otherwise); }

  void write_kept(TimePoint started) {
    write(plans_, started);
    write(app_changes_, started);
    write(clocks_, started);
  }

 private:
  template <class Event>
  void put(const Event& event, TimePoint begin, TimePoint end) {
    first_ = std::min(first_.value_or(begin), begin);
    last_ = std::max(last_, end);
    forward(event);
  }
  template <class Event>
  void keep(std::vector<Event>& kept, const Event& event) {
    if (seen_.insert(to_words(event)).second) kept.push_back(event);
  }
  template <class Event>
  void write(const std::vector<Event>& kept, TimePoint started) {
    for (Event event : kept) {
      event.at = std::max(event.at, started);
      forward(event);
    }
  }

  std::optional<TimePoint> first_;
  TimePoint last_{};
  std::set<std::vector<Word>> seen_;
  std::vector<record::PlanChange> plans_;
  std::vector<record::AppChange> app_changes_;
  std::vector<record::ClockReading> clocks_;
};

}  // namespace

struct Recording::Impl {
  struct Events {
    std::vector<Word> words;
    Word end = 0;   // the position after them
    Word lost = 0;  // words between `from` and the first of them
  };

  Impl(os::ReadOnlyMemory mapped, std::size_t image_bytes, graph::App of, record::Header known)
      : memory(std::move(mapped)), parts(memory.bytes(), image_bytes), app(std::move(of)), header(std::move(known)) {}

  Word oldest() const { return parts.head->oldest.load(std::memory_order_acquire); }
  Events copy(Word from) const;
  bool hand_on_all(const std::vector<Word>& words, record::Sink& to) const;

  os::ReadOnlyMemory memory;
  Parts<const std::byte> parts;
  graph::App app;
  record::Header header;
  std::optional<Word> read_to{};  // where the next read begins; none: nothing was read yet
};

// All complete entries from `from` on that were not overwritten.
Recording::Impl::Events Recording::Impl::copy(Word from) const {
  Events copied;
  copied.end = parts.head->end.load(std::memory_order_acquire);
  const Word first = std::max(from, oldest());
  if (copied.end < first || copied.end - first > parts.ring.size()) {  // no recorder would write this
    copied.lost = copied.end > from ? copied.end - from : 1;
    return copied;
  }
  copied.words.reserve(copied.end - first);
  for (Word position = first; position < copied.end; ++position) {
    copied.words.push_back(parts.ring[position % parts.ring.size()].load(std::memory_order_acquire));
  }
  const Word valid = std::clamp(oldest(), first, copied.end);
  copied.words.erase(copied.words.begin(), copied.words.begin() + static_cast<std::ptrdiff_t>(valid - first));
  copied.lost = valid - from;
  return copied;
}

// False: from some entry on, they are not events of this app.
bool Recording::Impl::hand_on_all(const std::vector<Word>& words, record::Sink& to) const {
  std::span<const Word> left(words);
  while (!left.empty()) {
    const Word length = left.front();
    if (length < 2 || length > left.size() || !hand_on(left.subspan(1, length - 1), app, to)) return false;
    left = left.subspan(length);
  }
  return true;
}

Recording::Recording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;
Recording::~Recording() = default;

Result<Recording> Recording::open(os::Descriptor descriptor) {
  Result<os::ReadOnlyMemory> memory = os::ReadOnlyMemory::open(std::move(descriptor), sizeof(Head));
  if (!memory) return memory.error();
  const auto* const head = reinterpret_cast<const Head*>(memory->bytes().data());
  if (head->magic.load(std::memory_order_acquire) != kMagic) return no_recording("it does not begin like one");
  const Word image_bytes = head->image_bytes.load(std::memory_order_relaxed);
  const Word ring_words = head->ring_words.load(std::memory_order_relaxed);
  const std::size_t room = words_for(memory->bytes().size() - sizeof(Head));
  if (ring_words == 0 || ring_words > room || image_bytes > (room - ring_words) * sizeof(Word) ||
      words_for(image_bytes) + ring_words != room) {
    return no_recording("the lengths of its parts are wrong");
  }
  const Parts<const std::byte> parts(memory->bytes(), image_bytes);
  // A copy, since another process may write to the memory meanwhile.
  const std::vector<std::byte> image(parts.image.begin(), parts.image.end());
  const Result<record::Reader> blank = record::Reader::of_image(image);
  if (!blank) return no_recording(blank.error().problems().front().what);
  return Recording(std::make_unique<Impl>(std::move(*memory), image_bytes, blank->app(), blank->header()));
}

const graph::App& Recording::app() const { return impl_->app; }
const record::Header& Recording::header() const { return impl_->header; }

std::int32_t Recording::process() const {
  return static_cast<std::int32_t>(impl_->parts.head->process.load(std::memory_order_relaxed));
}

TimePoint Recording::seen_alive() const {
  return TimePoint{Nanos{static_cast<std::int64_t>(impl_->parts.head->alive_ns.load(std::memory_order_relaxed))}};
}

bool Recording::over() const { return impl_->parts.head->over.load(std::memory_order_acquire) != 0; }

std::uint64_t Recording::read_new(record::Sink& to) {
  const Impl::Events events = impl_->copy(impl_->read_to.value_or(impl_->oldest()));
  impl_->read_to = events.end;
  const bool all = impl_->hand_on_all(events.words, to);
  return (events.lost + (all ? 0 : 1)) * sizeof(Word);
}

Status Recording::save(const std::string& path, const std::string& why, const os::HostFacts& host) const {
  const Impl::Events events = impl_->copy(0);
  const record::Header& header = impl_->header;
  Result<std::unique_ptr<record::Writer>> writer = record::Writer::create(path, impl_->app, header);
  if (!writer) return writer.error();
  Saver saver(**writer);
  static_cast<void>(impl_->hand_on_all(events.words, saver));
  TimePoint started = header.started;
  if (events.lost > 0) {
    started = std::max(started, saver.first().value_or(seen_alive()));
    (*writer)->begin_at(started, std::max(header.started + header.warm_up - started, Nanos{0}));
  }
  saver.write_kept(started);
  const TimePoint ended = saver.last_or(started);
  const double seconds = in_seconds(ended - started);
  (*writer)->add(record::Notice{ended, "flight-recorder",
                                fmt::format("the last {:.1f} s, as they were kept in memory: {}", seconds, why)});
  return (*writer)->close(ended, host);
}

}  // namespace ctn::flight
