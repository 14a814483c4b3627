// Lines of CSV.
//
// Thread safety: none; one owner. Memory: what is not written yet (64 KiB).
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
  // `columns`: the first line. Moments are told since `started`.
  CsvWriter(const Sink& sink, TimePoint started, std::string_view columns);

  // Fields of a line, from the left.
  CsvWriter& text(std::string_view value);
  CsvWriter& number(std::optional<std::uint64_t> value);  // none: empty
  CsvWriter& real(std::optional<double> value);           // none: empty
  CsvWriter& seconds(TimePoint at);
  CsvWriter& ms(Nanos duration);
  void end_line();

  // Writes what is left. The first failure of the sink, after which nothing was written.
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
