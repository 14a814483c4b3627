#include "serving_programs.h"

#include <utility>

#include "command.h"
#include "shown_record.h"
#include "status_line.h"

namespace ctn::tool {

Result<Served> serve_programs(const config::AppFile& file, const SchedulingOptions& scheduling,
                              const WatchedApp& watched, const std::string& record_path, ServingOptions serving,
                              std::string remark, const std::function<void(const Snapshot&)>& look) {
  auto scheduler = scheduling.for_scheduler(file.app, record_path);
  if (!scheduler) return scheduler.error();
  serving.scheduler = std::move(*scheduler);
  serving.scheduler.note = std::move(remark);
  const StatusLine status;
  serving.scheduler.on_notice = [&status](const std::string& text) {
    status.show({});
    note(text);
  };
  if (!watched.on_late.empty()) serving.watched = watched;
  if (look || status.shown()) {
    serving.on_progress = [&](const Snapshot& snapshot, double measured) {
      if (look) look(snapshot);
      if (status.shown()) status.show(status_text(snapshot, measured, serving.seconds));
    };
  }
  return serve(file, serving);
}

int show_served(const Served& served, const std::string& record_path, bool json) {
  if (const int shown = show_record(record_path, served.warmed_up, json); shown != kSuccess) return shown;
  return served.signal != 0 ? 128 + served.signal : served.exit_code;
}

}  // namespace ctn::tool
