// What a session or a simulation has measured, as JSON, for the documents that the apps' programs print.
//
// Thread safety: pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "catan/snapshot.h"
#include "program/calibration.h"
#include "program/figures.h"
#include "program/thread_use.h"

namespace ctn::program {

nlohmann::ordered_json or_null(const std::optional<double>& value);
nlohmann::ordered_json json_of(const Summary& summary);
nlohmann::ordered_json json_of(const std::vector<Figure>& figures);        // an object
nlohmann::ordered_json json_of(const std::vector<FigureSpread>& spreads);  // an object
nlohmann::ordered_json json_of(const ByTime& numbers);                     // a list
nlohmann::ordered_json json_of(const ThreadUse& use);

std::string name_of(const ChainSnapshot& chain);  // "a -> b"

// The text of a document.
std::string text_of(const nlohmann::ordered_json& json);

// Text: on what a run took place. `cores`: of virtual time.
std::string machine_of(bool virtual_time, int cores, const Snapshot& snapshot);

// Text: a figure a line.
std::string list_of(const std::vector<Figure>& figures);

// Text: rates and compute times of nodes, and in how far these are what is charged in virtual time, where it is known.
std::string table_of_nodes(const Snapshot& snapshot, const CostRatios& ratios);

// Adds to a document on which machine the run with these options of an app took place, and what it read (inputs.h).
template <class Options>
void add_machine(const Options& options, nlohmann::ordered_json& document) {
  document["inputs"] = options.inputs;
  document["calibration"] = options.calibration.of(options.seed);
  if (options.virtual_time) {
    document["cores"] = options.cores;
  } else {
    document["cpus"] = options.cpus;
  }
}

// Adds chains, nodes (with their `cost_ratio`, where it is known), the number of plans, and notices.
void add_snapshot(const Snapshot& snapshot, const CostRatios& ratios, nlohmann::ordered_json& document);

// What is the same of all runs of a batch, by `identity`, JSON of what one of them was asked for.
template <class Options>
nlohmann::ordered_json batch_document(const std::string& identity, const Options& options) {
  nlohmann::ordered_json document = nlohmann::ordered_json::parse(identity);
  if (options.calibration.by_seed()) document.erase("calibration");
  return document;
}

// What runs of one batch must have in common. A run's document names these of its members in `in_common`, so that
// others than its program can tell, too.
//
// Of `options`, all that a run was asked for: without `seed` and `calibration`, of which each run may have its own.
nlohmann::ordered_json in_common(const nlohmann::ordered_json& options);
// Adds `in_common` to the document of a run with these options; of one in life, `real_time` is among the names, too.
void add_in_common(const nlohmann::ordered_json& options, nlohmann::ordered_json& document);
// The members that a document names so; none: it names none. Precondition: it is an object.
std::optional<nlohmann::ordered_json> common_options_in(const nlohmann::ordered_json& document);

// Whether a document is the outcome of a run: an object that has `figures`.
bool has_figures(const nlohmann::ordered_json& document);
// Precondition: has_figures().
std::vector<Figure> figures_in(const nlohmann::ordered_json& document);
// The numbers of a list, none for what is no number. Precondition: it is a list.
ByTime by_time_in(const nlohmann::ordered_json& list);

}  // namespace ctn::program
