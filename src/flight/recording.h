// What a flight recorder (recorder.h) keeps, read while it is being written: by another thread, by another process that
// has the memory's descriptor (`catan top`, `catan ctl dump`), also once its writer was killed.
//
// The memory is mapped read-only, and nothing that a reader does reaches its writer: a reader that is slow, hangs or
// dies misses events, no more. Nothing in the memory is trusted: whatever it holds, reading ends, and ids that are
// handed on are ids of the app.
//
// Units: instants of the monotonic clock, which all processes of a machine share. Thread safety: none; one owner. Any
// number of them read the same memory.
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
  // kEnvironment: it is no memory of a flight recorder, or that of another version of Catan.
  static Result<Recording> open(os::Descriptor memory);

  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) noexcept;
  ~Recording();

  // As the run began: weights and bounds that were changed since are among the events, and always kept.
  const graph::App& app() const;
  const record::Header& header() const;
  std::int32_t process() const;  // that writes it, as it sees itself
  // When the writer last showed that it lives, which it does each 50 ms.
  TimePoint seen_alive() const;
  // It has ended in order: nothing more will come.
  bool over() const;

  // Hands on what was kept since the last call, in the order in which it was reported; the first time all that there
  // is: the newest events, and what holds until now (the plan in force, weights and bounds that were changed, clocks of
  // external nodes, totals), however old. What holds may come more than once. Returns how many bytes were overwritten
  // before they were read: not 0, where the reader was away for too long, or nothing could be made of them.
  std::uint64_t read_new(record::Sink& to);

  // Saves all that there is as a new record, to be read as any other (record/reader.h); it begins with the oldest event
  // that is kept. `why` is told in it, as a notice of the kind "flight-recorder". Independent of read_new(). Errors: as
  // Writer::create() has them.
  Status save(const std::string& path, const std::string& why, const os::HostFacts& host) const;

 private:
  struct Impl;
  explicit Recording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ctn::flight
