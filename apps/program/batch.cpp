#include "program/batch.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "program/snapshot_json.h"
#include "program/text_file.h"

namespace ctn::program {
namespace {

Error cannot_write(const std::filesystem::path& path) {
  return Error::environment(fmt::format("{} cannot be written", path.string()), "name another folder with --out");
}

// "; about 4 min left"
std::string left(double seconds) {
  if (seconds < 1.0) return "";
  return seconds < 120.0 ? fmt::format("; about {:.0f} s left", seconds)
                         : fmt::format("; about {:.0f} min left", seconds / 60.0);
}

constexpr const char* kLevels = "real_time";

// Whether real-time levels were enforced, as JSON, which a run in life alone can say; empty: it was in virtual time.
std::string levels_in(const nlohmann::ordered_json& document) {
  return document.contains(kLevels) ? document[kLevels].dump() : "";
}

// That of the first run of which there is an outcome.
std::optional<std::string> stored_levels(Seeds seeds, const std::filesystem::path& folder) {
  for (int number = 0; number < seeds.count; ++number) {
    const auto text = text_of_file((folder / file_of_run(seeds.first + static_cast<std::uint64_t>(number))).string());
    const auto document = nlohmann::ordered_json::parse(text.value_or(""), nullptr, false);
    if (has_figures(document)) return levels_in(document);
  }
  return std::nullopt;
}

// Whether a run's document says the same of real-time levels as those before: `levels`, which are now known.
Status check_levels(const std::string& text, const std::string& run, std::optional<std::string>& levels) {
  const auto document = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!has_figures(document)) return Done{};
  const std::string these = levels_in(document);
  if (!levels) levels = these;
  if (these == *levels) return Done{};
  const auto word = [](const std::string& value) { return value.empty() ? "none" : value; };
  return Error::caller(
      fmt::format("{} has another {} than runs that are there ({}, not {})", run, kLevels, word(these), word(*levels)),
      "run it with the same permissions as these, or name another folder with --out");
}

}  // namespace

std::string file_of_run(std::uint64_t seed) { return fmt::format("run-{}.json", seed); }

Result<int> run_batch(Seeds seeds, const std::string& folder, const BatchSteps& steps) {
  const bool keeps = !folder.empty();
  std::error_code error;
  if (keeps) {
    std::filesystem::create_directories(folder, error);
    if (error) return cannot_write(folder);
  }
  std::optional<std::string> levels = keeps ? stored_levels(seeds, folder) : std::nullopt;
  double took = 0.0;
  int measured = 0;
  for (int number = 1; number <= seeds.count; ++number) {
    const std::uint64_t seed = seeds.first + static_cast<std::uint64_t>(number - 1);
    const std::filesystem::path path = std::filesystem::path(folder) / file_of_run(seed);
    const auto line_of = [&](const std::string& words) {
      return fmt::format("run {} of {}, seed {}: {}", number, seeds.count, seed, words);
    };
    if (keeps && std::filesystem::exists(path, error)) {
      const std::string text = text_of_file(path.string()).value_or("");
      const auto words = steps.take(text, path.string(), seed);
      if (!words) return words.error();
      if (Status alike = check_levels(text, path.string(), levels); !alike) return alike.error();
      steps.tell(line_of(*words) + " (from " + path.string() + ")");
      continue;
    }
    const auto document = steps.run(seed);
    if (!document) return document.error();
    if (document->signal != 0) return document->signal;
    if (Status alike = check_levels(document->text, fmt::format("the run with seed {}", seed), levels); !alike) {
      return alike.error();
    }
    if (keeps && !replace_file(path.string(), document->text)) return cannot_write(path);
    const auto words = steps.take(document->text, "the outcome", seed);
    if (!words) return words.error();
    took += document->took_seconds;
    ++measured;
    steps.tell(line_of(*words) + left(took / measured * (seeds.count - number)));
  }
  return 0;
}

Status check_document(const std::string& text, const std::string& file, const std::string& identity) {
  const auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  const char* const kHint = "name another folder with --out, or delete the file";
  if (!has_figures(json)) {
    return Error::caller(fmt::format("{} is no outcome of a run", file), kHint);
  }
  const auto asked = nlohmann::ordered_json::parse(identity);
  for (const auto& [key, value] : asked.items()) {
    if (json.contains(key) && json[key] == value) continue;
    return Error::caller(fmt::format("{} is of a run with another {} ({}, not {})", file, key,
                                     json.contains(key) ? json[key].dump() : "none", value.dump()),
                         kHint);
  }
  return Done{};
}

}  // namespace ctn::program
