// A closer look at what the trials measure: two more of them that are recorded, under Catan and under the default on as
// many cores as there are, and their page as `catan report --html --compare` makes it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "base/result.h"
#include "experiment.h"
#include "page/page.h"

namespace ctn::demo {

inline constexpr const char* kLookPage = "run.html";

// They do not count in the results. Catan's first.
std::array<Trial, 2> looked_at(const Setting& setting);

// Where a trial of them is recorded.
std::filesystem::path record_of(const std::filesystem::path& folder, const Trial& trial);

// Writes the page beside the records. What another page may begin with; nothing where the records are not there.
// Errors: a record that cannot be read, a page that cannot be written.
Result<std::optional<page::Glance>> write_look(const std::filesystem::path& folder, const Setting& setting);

}  // namespace ctn::demo
