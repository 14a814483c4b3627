// The line on a terminal that says how a run goes, while it goes.
#pragma once

#include <optional>
#include <string>

#include "catan/snapshot.h"

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
};

// `seconds`: that are to be measured; none: until something ends the run. Bounds that the plan in force relaxes and
// costs that it assumes are in it for as long as that lasts.
std::string status_text(const Snapshot& snapshot, double measured_s, std::optional<double> seconds);

}  // namespace ctn::tool
