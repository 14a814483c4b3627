// The line on a terminal that says how a run goes, while it goes. A terminal that does not read (Ctrl-S) misses it, and
// keeps nobody waiting: who shows the line has an app to schedule.
#pragma once

#include <optional>
#include <string>

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

// `seconds`: that are to be measured; none: until something ends the run. Bounds that the plan in force relaxes and
// costs that it assumes are in it for as long as that lasts.
std::string status_text(const Snapshot& snapshot, double measured_s, std::optional<double> seconds);

}  // namespace ctn::tool
