// Writes lines of CSV.
//
// Thread safety: none; one owner. Memory: lines that are not written yet (64 KiB).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/time.h"
#include "export/output.h"

namespace ctn::exports {

class CsvWriter {
 public:
  // `columns`: the first line. Instants are written as seconds since `started`.
  CsvWriter(const Sink& sink, TimePoint started, std::string_view columns);

  // Add the next field of the line.
  CsvWriter& text(std::string_view value);
  CsvWriter& number(std::optional<std::uint64_t> value);  // none: empty
  CsvWriter& real(std::optional<double> value);           // none: empty
  CsvWriter& seconds(TimePoint at);
  CsvWriter& ms(Nanos duration);
  void end_line();

  // Writes what is left. Returns the first failure of the sink, after which nothing was written.
  Status finish();

 private:
  void separate();
  void flush();

  const Sink& sink_;
  TimePoint started_;
  std::string lines_;
  bool in_line_ = false;
  Status status_ = Done{};
};

}  // namespace ctn::exports
