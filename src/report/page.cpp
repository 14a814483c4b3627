#include "report/page.h"

#include <algorithm>

#include "report/html.h"
#include "report/text.h"

namespace ctn::report {

std::string to_html(const RunFigures& metrics) {
  const record::Header& header = metrics.header;
  Page page("Run of " + metrics.app, headline(metrics));
  std::string started = header.host.utc;
  std::replace(started.begin(), started.end(), 'T', ' ');  // where a line may break
  page.facts({{"Started", started},
              {"Scheduler", header.scheduler},
              {"CPUs", os::to_string(header.cpus)},
              {"Real-time levels", header.real_time ? "yes" : "no"},
              {"Processor", header.host.cpu_model}});
  if (!header.note.empty()) page.note(header.note);
  for (const std::string& warning : warnings(metrics)) page.note(warning, NoteKind::kWarning);
  for (Table table : tables(metrics)) {
    page.section(table.caption);
    table.caption.clear();
    page.table(table);
  }
  page.paragraph("Kernel: " + header.host.kernel);
  return page.html();
}

}  // namespace ctn::report
