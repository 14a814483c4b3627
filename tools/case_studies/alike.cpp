#include "alike.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "program/batch.h"
#include "program/fingerprint.h"
#include "program/text_file.h"

namespace ctn::case_studies {
namespace {

using RunOptions = std::map<std::string, std::string>;

// Without what JSON puts around words and around a list of one.
std::string bare(std::string text) {
  std::erase_if(text, [](char letter) { return letter == '"' || letter == '[' || letter == ']'; });
  return text;
}

std::optional<double> number_of(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? std::nullopt : std::optional(number);
}

// As one may write them: 90 is 90.0.
bool is_the_same(const std::string& stored, const std::string& asked) {
  const std::string a = bare(stored);
  const std::string b = bare(asked);
  const auto number = number_of(a);
  return a == b || (number && number == number_of(b));
}

// By the names that runs store them by: "--mover-speed 2" is mover_speed. What runs do not store does no harm.
RunOptions asked_by(const std::vector<std::string>& arguments) {
  RunOptions asked;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--no-stealing") asked["stealing"] = "false";
    if (!arguments[i].starts_with("--") || i + 1 == arguments.size() || arguments[i + 1].starts_with("--")) continue;
    std::string name = arguments[i].substr(2);
    std::ranges::replace(name, '-', '_');
    asked[name] = arguments[i + 1];
  }
  // What is in a map of one's own may have changed; 1, 2 and crowd are the app's.
  const auto map = asked.find("map");
  if (map != asked.end() && map->second != "1" && map->second != "2" && map->second != "crowd") {
    if (const auto text = program::text_of_file(map->second)) {
      program::Fingerprint fingerprint;
      fingerprint.add(*text);
      asked["inputs.world"] = fmt::format("{:016x}", fingerprint.value());
    }
  }
  return asked;
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

Alike alike(std::vector<StoredRun> runs, const std::vector<std::string>& arguments) {
  constexpr const char* kHint = "delete what is not meant, or name another folder with --out";
  Alike result;
  const RunOptions asked = asked_by(arguments);
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
