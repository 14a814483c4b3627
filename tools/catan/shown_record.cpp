#include "shown_record.h"

#include "command.h"
#include "record/reader.h"
#include "report/json.h"
#include "report/metrics.h"
#include "report/text.h"

namespace ctn::tool {

int show_record(const std::string& path, bool warm, bool json) {
  const auto record = record::Reader::open(path);
  if (!record) return report_error(record.error());
  const auto metrics = report::measure(*record, {.whole = !warm, .worst = 0});
  if (!metrics) return report_error(metrics.error());
  print(json ? report::to_json(*metrics) : report::to_text(*metrics));
  return kSuccess;
}

}  // namespace ctn::tool
