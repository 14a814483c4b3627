// The metrics of a run for people: on a terminal, or as a page.
#pragma once

#include <string>
#include <vector>

#include "report/metrics.h"
#include "report/table.h"

namespace ctn::report {

// Chains, late responses, nodes, triggers; those that have rows. What there is of each is in the caption.
std::vector<Table> tables(const RunFigures& metrics);

// One line: what ran, under which scheduler, where, and how long of it is measured.
std::string headline(const RunFigures& metrics);

// What a reader must know before they believe the figures: an unfinished record, bounds that were relaxed, notices.
std::vector<std::string> warnings(const RunFigures& metrics);

// "pre-empted 8, long-run 4", of the late responses of a chain; "-" if none was late.
std::string causes_in_words(const why::Analysis& late);

std::string to_text(const RunFigures& metrics);

}  // namespace ctn::report
