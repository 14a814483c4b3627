// The results as figures, as a page and as a table for a terminal. Pure, save that figures are drawn by gnuplot.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "page/page.h"
#include "report/plot.h"
#include "results.h"
#include "summary.h"

namespace ctn::demo {

// Over the source rate, a panel for each number of cores.
report::Figure response_figure(const Summary& summary, double speed);
report::Figure angle_figure(const Summary& summary, double speed);

// How many trials there were in how many rounds, and in which of these rates set by hand were tried.
std::string rounds_text(const Results& results);

// It begins with a glance at a run, where there is one, and leads to that run's own page. Errors: gnuplot is missing or
// fails.
Result<std::string> render_page(const Results& results, const std::optional<page::Glance>& glance = std::nullopt);

// What the terminal shows in the end: the main rows and the claims.
std::string to_text(const Results& results);

}  // namespace ctn::demo
