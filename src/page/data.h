// What a page's script draws: a story as JSON, with packed numbers (pack.h). The keys are explained where the script
// reads them (script/).
#pragma once

#include <string>
#include <vector>

#include "page/detail.h"
#include "page/story.h"

namespace ctn::page {

// `colours`: CSS colours, by lane.
std::string data_of(const Story& story, const std::string& name, const Detail& detail,
                    const std::vector<std::string>& colours);

// Compute times of a node, in ms: by mode, run by run.
using ModeSamples = std::vector<std::vector<double>>;
// By NodeId.
std::vector<ModeSamples> compute_samples_ms(const Story& story);

}  // namespace ctn::page
