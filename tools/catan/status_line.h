// The line on a terminal that says how a run goes, while it goes, or how far a command is. A terminal that does not
// read (Ctrl-S) misses it, and keeps nobody waiting: who shows the line may have an app to schedule.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "catan/snapshot.h"
#include "os/linux/descriptor.h"

namespace ctn::tool {

// Nothing is shown where stderr is no terminal.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine() { show({}); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool shown() const { return terminal_; }
  void show(const std::string& line) const;

 private:
  bool terminal_;
  os::Descriptor screen_;  // the terminal once more, which a write does not wait for; invalid: it cannot be opened
};

// Says how far a command is that takes long, from its third second on.
class ProgressLine {
 public:
  // `what` is done to a part of it: "exported".
  explicit ProgressLine(std::string what) : what_(std::move(what)) {}

  // As often as one likes: most of it is not shown.
  void show(double part);                // from 0 to 1
  void show_count(std::uint64_t count);  // of events, where the whole is not known
  // The line is empty, and stays so: what comes now is not in its way.
  void end();

 private:
  bool is_due();

  std::string what_;
  StatusLine line_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + std::chrono::seconds{2};
};

// `seconds`: that are to be measured; none: until something ends the run. Bounds that the plan in force relaxes and
// costs that it assumes are in it for as long as that lasts.
std::string status_text(const Snapshot& snapshot, double measured_s, std::optional<double> seconds);

}  // namespace ctn::tool
