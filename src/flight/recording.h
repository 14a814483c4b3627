// A recording: what a flight recorder (recorder.h) keeps, as its readers see it. It can be read while it is written, by
// another thread or by another process that has the memory's descriptor (`catan top`, `catan ctl dump`), and after its
// writer was killed.
//
// The memory is mapped read-only, and nothing that a reader does reaches the writer: a reader that is slow, hangs or
// dies only misses events. Nothing in the memory is trusted: whatever it holds, reading comes to an end, and ids that
// are handed on are ids of the app.
//
// Units: instants of the monotonic clock, which all processes of a machine share. Thread safety: none; one owner. Any
// number of recordings may read the same memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "base/time.h"
#include "graph/app.h"
#include "os/linux/descriptor.h"
#include "os/machine.h"
#include "record/sink.h"
#include "record/writer.h"

namespace ctn::flight {

class Recording {
 public:
  // kEnvironment: not the memory of a flight recorder, or written by another version of Catan.
  static Result<Recording> open(os::Descriptor memory);

  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) noexcept;
  ~Recording();

  // As they were when the run began. Changes of weights and bounds are events, which are always kept.
  const graph::App& app() const;
  const record::Header& header() const;
  std::int32_t process() const;  // the writer's, as numbered in its own PID namespace
  // When the writer last showed that it lives, which it does every 50 ms.
  TimePoint seen_alive() const;
  // Whether the run has ended in order: nothing more will come.
  bool over() const;

  // Hands on the events since the last call, in the order in which they were reported. The first call hands on all
  // that is kept: the newest events, and what still holds (the plan in force, weights and bounds that were changed,
  // clocks of external nodes, totals), however old; this may come more than once. Returns how many bytes were lost,
  // since they were overwritten before they were read; 8 more where the rest of what was read made no sense.
  std::uint64_t read_new(record::Sink& to);

  // Saves all that is kept as a new record, which is read like any other (record/reader.h) and begins with the oldest
  // event that is kept. `why` goes into it as a notice of the kind "flight-recorder". Independent of read_new().
  // Errors: as Writer::create() has them.
  Status save(const std::string& path, const std::string& why, const os::HostFacts& host) const;

 private:
  struct Impl;
  explicit Recording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn::flight
