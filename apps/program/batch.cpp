#include "program/batch.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
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

Status store(const std::filesystem::path& path, const std::string& text) {
  const std::filesystem::path unfinished = path.string() + ".unfinished";
  {
    std::ofstream file(unfinished, std::ios::binary | std::ios::trunc);
    if (!(file << text).flush()) return cannot_write(unfinished);
  }
  std::error_code error;
  std::filesystem::rename(unfinished, path, error);
  if (error) return cannot_write(path);
  return Done{};
}

// "; about 4 min left"
std::string left(double seconds) {
  if (seconds < 1.0) return "";
  return seconds < 120.0 ? fmt::format("; about {:.0f} s left", seconds)
                         : fmt::format("; about {:.0f} min left", seconds / 60.0);
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
  double took = 0.0;
  int measured = 0;
  for (int number = 1; number <= seeds.count; ++number) {
    const std::uint64_t seed = seeds.first + static_cast<std::uint64_t>(number - 1);
    const std::filesystem::path path = std::filesystem::path(folder) / file_of_run(seed);
    const auto line_of = [&](const std::string& words) {
      return fmt::format("run {} of {}, seed {}: {}", number, seeds.count, seed, words);
    };
    if (keeps && std::filesystem::exists(path, error)) {
      const auto words = steps.take(text_of_file(path.string()).value_or(""), path.string(), seed);
      if (!words) return words.error();
      steps.tell(line_of(*words) + " (from " + path.string() + ")");
      continue;
    }
    const auto document = steps.run(seed);
    if (!document) return document.error();
    if (document->signal != 0) return document->signal;
    if (keeps) {
      if (Status stored = store(path, document->text); !stored) return stored.error();
    }
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
