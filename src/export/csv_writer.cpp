#include "export/csv_writer.h"

#include <fmt/format.h>

#include <cstdlib>
#include <iterator>

namespace ctn::exports {
namespace {

constexpr std::size_t kFull = 64 << 10;

// A number of nanoseconds in a unit of `per_unit`, in full.
void append_decimal(std::string& to, std::int64_t nanos, std::int64_t per_unit, int digits) {
  const std::int64_t size = std::abs(nanos);
  fmt::format_to(std::back_inserter(to), "{}{}.{:0{}}", nanos < 0 ? "-" : "", size / per_unit, size % per_unit, digits);
}

}  // namespace

CsvWriter::CsvWriter(const Sink& sink, TimePoint started, std::string_view columns)
    : sink_(sink), started_(started), lines_(columns) {
  end_line();
}

CsvWriter& CsvWriter::text(std::string_view value) {
  separate();
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) {
    lines_ += value;
    return *this;
  }
  lines_ += '"';
  for (const char c : value) lines_.append(c == '"' ? 2 : 1, c);
  lines_ += '"';
  return *this;
}

CsvWriter& CsvWriter::number(std::optional<std::uint64_t> value) {
  separate();
  if (value) fmt::format_to(std::back_inserter(lines_), "{}", *value);
  return *this;
}

CsvWriter& CsvWriter::real(std::optional<double> value) {
  separate();
  if (value) fmt::format_to(std::back_inserter(lines_), "{}", *value);
  return *this;
}

CsvWriter& CsvWriter::seconds(TimePoint at) {
  separate();
  append_decimal(lines_, (at - started_).count(), 1'000'000'000, 9);
  return *this;
}

CsvWriter& CsvWriter::ms(Nanos duration) {
  separate();
  append_decimal(lines_, duration.count(), 1'000'000, 6);
  return *this;
}

void CsvWriter::end_line() {
  lines_ += '\n';
  in_line_ = false;
  if (lines_.size() >= kFull) flush();
}

Status CsvWriter::finish() {
  flush();
  return status_;
}

void CsvWriter::separate() {
  if (in_line_) lines_ += ',';
  in_line_ = true;
}

void CsvWriter::flush() {
  if (status_ && !lines_.empty()) status_ = sink_(lines_);
  lines_.clear();
}

}  // namespace ctn::exports
