// Reads the record of a run: a file that writer.h made, whole, still being written, or left by a process that was
// killed. It trusts nothing in the file: what no writer writes is an error, never a crash.
//
// The file is not changed, with one exception: where a kill hit the writer in the middle of a flush, a journal lies
// next to it, and opening the record takes the half-written batch back out of the file.
//
// Units: nanoseconds of the monotonic clock of the machine that ran. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "record/events.h"
#include "record/writer.h"

namespace ctn::record {

// Whether the file begins as records do; whether it is one, Reader::open() says. False where it cannot be read.
bool looks_like_record(const std::string& path);

// How a run ended.
struct Ending {
  bool closed = false;  // the writer closed the record; false: it is being written, or its process was killed
  TimePoint ended{};    // where not closed: of the last event that was written
  Nanos stolen{0};      // CPU time that a hypervisor took from the machine meanwhile, all CPUs; 0 where not closed
  Nanos starved{0};     // time for which the kernel kept cores from controllers, at least; 0 where not closed
};

class Reader {
 public:
  // Errors: no such file, no record, damaged, made by a newer version of Catan (kCaller); not to be read
  // (kEnvironment).
  static Result<Reader> open(const std::string& path);
  // Of the bytes of such a file, as Writer::blank() gives them: a copy is read. Errors: as open().
  static Result<Reader> of_image(std::span<const std::byte> image);

  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;
  ~Reader();

  // As the writer had it: ids in the events below are ids of this graph.
  const graph::App& app() const;
  const Header& header() const;
  const Ending& ending() const;

  // Is told from time to time how many events have been handed on so far, of all calls together. Empty: nobody is.
  void on_progress(std::function<void(std::uint64_t events)> tell);

  // All runs, by the time they ended: runs of a node in the order of their numbers, and a run after those it consumed,
  // as ChainTracker wants them. What a run consumed is in the order of the predecessors' ids.
  Status each_run(const std::function<void(const Run&)>& take) const;
  // All runs, by the time they began; of those that began at once, the longest first. What they consumed is left out.
  Status each_run_by_begin(const std::function<void(const Run&)>& take) const;
  // All runs, by node, in the order of their numbers, with the runs that consumed them.
  Status each_run_with_consumers(const std::function<void(const Run&, std::span<const Consumer>)>& take) const;
  // By subchain, in the order of their numbers.
  Status each_trigger(const std::function<void(const Trigger&)>& take) const;
  // In the order they were reported, which is by time for each core.
  Status each_slot(const std::function<void(const SlotUse&)>& take) const;
  Status each_steal(const std::function<void(const Steal&)>& take) const;
  Status each_overrun(const std::function<void(const Overrun&)>& take) const;
  // In the order they were written.
  Result<std::vector<PlanChange>> plans() const;
  Result<std::vector<CostChange>> cost_changes() const;  // none in records of versions that did not look for them
  Result<std::vector<AppChange>> app_changes() const;    // none in records of versions that could not make any
  Result<std::vector<ClockReading>> clocks() const;      // of external nodes; none in records of versions without
  Result<std::vector<Notice>> notices() const;

 private:
  struct Impl;
  explicit Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn::record
