#include "alike.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "program/batch.h"

namespace ctn::case_studies {
namespace {

// Of options of one name: 90 is 90.0.
bool is_the_same(const std::string& stored, const std::string& asked) {
  return nlohmann::json::parse(stored) == nlohmann::json::parse(asked);
}

// For readers: without what JSON puts around words and around a list of one.
std::string bare(std::string text) {
  std::erase_if(text, [](char letter) { return letter == '"' || letter == '[' || letter == ']'; });
  return text;
}

// "another seconds (3.0, not 90)"; nothing where what both have is the same.
std::optional<std::string> difference(const RunOptions& stored, const RunOptions& asked) {
  for (const auto& [name, value] : asked) {
    const auto found = stored.find(name);
    if (found == stored.end() || is_the_same(found->second, value)) continue;
    return fmt::format("another {} ({}, not {})", name, bare(found->second), bare(value));
  }
  return std::nullopt;
}

}  // namespace

Alike alike(std::vector<StoredRun> runs, const RunOptions& asked) {
  constexpr const char* kHint = "delete what is not meant, or name another folder with --out";
  Alike result;
  std::size_t others = 0;
  for (StoredRun& run : runs) {
    const auto why = difference(run.options, asked);
    if (why && ++others == 1) result.left_out = fmt::format("{} is of {}", program::file_of_run(run.seed), *why);
    if (!why) result.runs.push_back(std::move(run));
  }
  if (others > 0) {
    result.left_out = fmt::format("{} of {} runs are left out: {}; {}", others, runs.size(), result.left_out, kHint);
  }
  for (const StoredRun& run : result.runs) {
    const StoredRun& first = result.runs.front();
    if (run.options == first.options) continue;
    const auto why = difference(run.options, first.options);
    result.left_out = fmt::format("no run is taken: {} and {} were made with different options or files{}; {}",
                                  program::file_of_run(first.seed), program::file_of_run(run.seed),
                                  why ? ", the second with " + *why : "", kHint);
    result.runs.clear();
    break;
  }
  return result;
}

}  // namespace ctn::case_studies
