#include "program/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <system_error>

namespace ctn::program {
namespace {

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0 || value > 4095) return std::nullopt;
  return value;
}

// Ascending and without doubles. Nothing where the text is no list of CPUs.
std::optional<std::vector<int>> parse_cpus(const std::string& text) {
  std::vector<int> cpus;
  std::stringstream parts(text + ",");
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t dash = part.find('-');
    const auto first = whole_number(std::string_view(part).substr(0, dash));
    const auto last = dash == std::string::npos ? first : whole_number(std::string_view(part).substr(dash + 1));
    if (!first || !last || *last < *first) return std::nullopt;
    for (int cpu = *first; cpu <= *last; ++cpu) cpus.push_back(cpu);
  }
  std::ranges::sort(cpus);
  if (cpus.empty() || std::ranges::adjacent_find(cpus) != cpus.end()) return std::nullopt;
  return cpus;
}

}  // namespace

std::optional<Leave> parse(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return Leave{0, app.help()};
  } catch (const CLI::ParseError& error) {
    return Leave{kMistake, fmt::format("{0}: {1}\nSee {0} --help.\n", app.get_name(), error.what())};
  }
  return std::nullopt;
}

std::optional<std::string> take_cpus(const std::string& text, std::vector<int>& cpus) {
  if (text.empty()) return std::nullopt;
  const auto list = parse_cpus(text);
  if (!list) return fmt::format("--cpus: '{}' is no list of CPUs; write 0 or 0,1 or 0-3", text);
  cpus = *list;
  return std::nullopt;
}

Leave leave_over(const std::string& program, const std::string& mistake) {
  return {kMistake, fmt::format("{}: {}\n", program, mistake)};
}

CLI::Validator within(double min, double max) {
  const auto check = [=](const std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= min && value <= max) return {};
    return fmt::format("'{}' is no number from {} to {}", text, min, max);
  };
  return {check, fmt::format("from {} to {}", min, max)};
}

void add_calibration(CLI::App& app, std::string& file, CLI::Option* in_virtual_time) {
  app.add_option("--calibration", file,
                 "with --virtual: runs cost as much as in a run in real time, by what that printed with --json; or by "
                 "the folder of a batch of those, each run by the one of its seed")
      ->type_name("FILE|DIR")
      ->needs(in_virtual_time);
}

std::string file_of_the_app(const std::string& name) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  const std::filesystem::path beside = folder / name;
  if (!error && std::filesystem::exists(beside, error)) return beside.string();
  return (folder / "../share/catan/apps" / name).lexically_normal().string();
}

}  // namespace ctn::program
