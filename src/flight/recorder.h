// A flight recorder: always keeps the last seconds of what happens in a run in a ring in memory, so that they can be
// read while the app runs (recording.h), and saved when it matters: a response was late, the server was killed.
//
// Processes can share the memory (os/linux/shared_memory.h): it lives for as long as one of them has a descriptor of
// it, and every process that may look at this one's descriptors can find it (find.h). Adding an event copies some tens
// of words, waits for nothing, and makes no system call.
//
// What holds until it is replaced (the plan in force, weights and bounds that were changed, the clocks of external
// nodes, totals) is written again before it would be overwritten, so that every reader finds it, however old it is; as
// long as all of that takes no more than an eighth of the ring. An event that takes an eighth or more is left out.
//
// Units: bytes; instants of the monotonic clock. Thread safety: none; one owner, in a session the housekeeping thread.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "flight/event_words.h"
#include "flight/layout.h"
#include "graph/app.h"
#include "os/linux/descriptor.h"
#include "os/linux/shared_memory.h"
#include "os/threads.h"
#include "record/sink.h"
#include "record/writer.h"

namespace ctn::flight {

class Recorder : public record::Sink {
 public:
  static constexpr std::size_t kDefaultBytes = std::size_t{8} << 20;
  static constexpr std::size_t kMinBytes = std::size_t{64} << 10;

  // With a ring of `bytes`, and at least kMinBytes. Errors: as SharedMemory::create() has them.
  static Result<std::unique_ptr<Recorder>> create(const graph::App& app, const record::Header& header,
                                                  os::ProcessId process, std::size_t bytes);
  ~Recorder() override { end(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void add(const record::Run& run) override { push(to_words(run)); }
  void add(const record::Trigger& trigger) override { push(to_words(trigger)); }
  void add(const record::SlotUse& slot) override { push(to_words(slot)); }
  void add(const record::Steal& steal) override { push(to_words(steal)); }
  void add(const record::Overrun& overrun) override { push(to_words(overrun)); }
  void add(const record::PlanChange& change) override { keep({What::kPlan, 0}, to_words(change)); }
  void add(const record::CostChange& change) override { push(to_words(change)); }
  void add(const record::AppChange& change) override;
  void add(const record::ClockReading& reading) override {
    keep({What::kClock, reading.node.index()}, to_words(reading));
  }
  void add(const record::Notice& notice) override { push(to_words(notice)); }
  void set_totals(const record::Totals& totals) override;

  // Shows readers that the writer lives. To be called about every 50 ms.
  void show_alive(TimePoint now);

  // Tells readers that the run has ended in order.
  void end() { parts_.head->over.store(1, std::memory_order_release); }

  // A descriptor for readers, in this process or others (Recording::open). From any thread. kEnvironment: no more files
  // can be opened.
  Result<os::Descriptor> readable() const { return memory_.read_only(); }

 private:
  enum class What { kPlan, kWeight, kMax, kMinRate, kClock, kTotals };
  using Subject = std::pair<What, std::size_t>;  // what holds until it is replaced, and of which item
  struct Kept {
    std::vector<Word> event;
    Word position = 0;  // where it was last written
  };

  Recorder(os::SharedMemory memory, std::size_t image_bytes);

  void push(const std::vector<Word>& event);
  // Adds an event that holds until the next one of the same subject.
  void keep(const Subject& subject, std::vector<Word> event);
  void write(const std::vector<Word>& event);
  void make_room(std::size_t words);
  bool fits(const std::vector<Word>& event) const;
  bool may_be_overwritten_next(Word position) const;
  void write_kept_again();

  os::SharedMemory memory_;
  Parts<std::byte> parts_;
  // The state below is kept outside the memory, which is never read here: another process may have written into it.
  std::deque<std::size_t> entries_;  // lengths of the entries in the ring, the oldest first
  Word oldest_ = 0;
  Word end_ = 0;
  std::map<Subject, Kept> kept_;
  record::Totals totals_;
};

}  // namespace ctn::flight
