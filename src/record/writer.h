// Writes the record of a run: one SQLite file, schema in docs/record-schema.md. The caller is a thread at the ordinary
// level that may block on the disk; nodes never do.
//
// Events are collected in memory, and `flush` writes them in one transaction: a process that is killed loses at most
// what came since, and leaves one readable file unless the kill hit a flush; then a journal lies next to it, from which
// the first reader puts the file in order (reader.h). Other programs may read the file meanwhile; one that holds it for
// long delays a flush, and the events wait in memory.
//
// Units: nanoseconds of the monotonic clock. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "os/machine.h"
#include "record/events.h"
#include "record/sink.h"

namespace ctn::record {

// What is known when a run starts.
struct Header {
  std::string scheduler;  // "catan", "default", "rate:30"
  os::CpuSet cpus;
  os::HostFacts host;
  bool real_time = false;       // false: rates only
  std::optional<double> slack;  // fraction of a core that plans leave to ordinary threads; none: no plans are made
  bool stealing = true;         // false: no subchain steals, whatever the app says
  TimePoint started{};
  Nanos warm_up{0};  // what happens in it after `started` is not what the run is measured by
  std::string note;  // free text, as "slowdown 2.0"
};

class Writer : public Sink {
 public:
  // Makes a new file; one that exists is kCaller (nothing recorded is ever overwritten), one that cannot be made
  // kEnvironment.
  static Result<std::unique_ptr<Writer>> create(const std::string& path, const graph::App& app, const Header& header);
  // The bytes of such a file, in which nothing has happened yet (Reader::of_image). kEnvironment: out of memory.
  static Result<std::vector<std::byte>> blank(const graph::App& app, const Header& header);
  // Totals that were set are written when it is closed.

  // Commits. The first failure (a full disk) is returned, and later calls return it again without writing. It is done
  // unasked, too, when much has accumulated. A node's run number that is added twice is a failure.
  virtual Status flush() = 0;
  // For what is known only once events were added: when the run, or what is kept of it, began, and how long its warm-up
  // takes from then on. In place of what the header said; written when the record is closed.
  virtual void begin_at(TimePoint started, Nanos warm_up) = 0;
  // Commits, marks the record as complete with the time it ended, closes the file. What is added later is ignored; a
  // second call returns what the first did.
  virtual Status close(TimePoint ended, const os::HostFacts& host) = 0;
};

}  // namespace ctn::record
