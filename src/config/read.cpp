#include "config/read.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <unordered_map>

#include "base/text.h"
#include "config/quantity.h"

namespace ctn::config {
namespace {

// A doubled key is reported where it is written again.
bool is_doubled(const Entry& entry, std::unordered_map<std::string_view, int>& lines, const std::string& key,
                Problems& problems) {
  const auto [first, fresh] = lines.try_emplace(entry.key, entry.place.line);
  if (fresh) return false;
  problems.add(entry.place, key, fmt::format("key {} was written before, in line {}", quote(entry.key), first->second),
               "keep one of them");
  return true;
}

std::string list_words(std::span<const std::string_view> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

// Like `expect`, for plain values: a list or a map where one value belongs.
bool expect_scalar(const Value& value, const std::string& key, std::string_view hint, Problems& problems) {
  return expect(value, ValueKind::kScalar, key, hint, problems);
}

}  // namespace

std::string join_key(std::string_view path, std::string_view key) {
  const std::string shown = quote(key);  // as long as it may be, and fit to print
  const std::string_view bare(shown.data() + 1, shown.size() - 2);
  return path.empty() ? std::string(bare) : fmt::format("{}.{}", path, bare);
}

MapReader::MapReader(const Value& map, std::string path, std::span<const std::string_view> known, Problems& problems)
    : map_(map), path_(std::move(path)) {
  const std::vector<std::string> names(known.begin(), known.end());
  std::unordered_map<std::string_view, int> lines;
  for (const Entry& entry : map_.entries) {
    if (is_doubled(entry, lines, key_of(entry.key), problems)) continue;
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    const auto meant = nearest(entry.key, names);
    problems.add(entry.place, key_of(entry.key), "there is no such key",
                 meant ? fmt::format("did you mean {}?", quote(*meant))
                       : fmt::format("the keys here are {}", list_words(known)));
  }
}

const Value* MapReader::find(std::string_view key) const {
  const auto found =
      std::find_if(map_.entries.begin(), map_.entries.end(), [&](const Entry& entry) { return entry.key == key; });
  return found == map_.entries.end() ? nullptr : &found->value;
}

std::string MapReader::key_of(std::string_view key) const { return join_key(path_, key); }

std::vector<const Entry*> read_entries(const Value& map, const std::string& key, Problems& problems) {
  std::vector<const Entry*> entries;
  std::unordered_map<std::string_view, int> lines;
  for (const Entry& entry : map.entries) {
    if (!is_doubled(entry, lines, join_key(key, entry.key), problems)) entries.push_back(&entry);
  }
  return entries;
}

bool expect(const Value& value, ValueKind kind, const std::string& key, std::string_view hint, Problems& problems) {
  if (value.kind == kind) return true;
  Value wanted;
  wanted.kind = kind;
  const std::string name = kind == ValueKind::kScalar ? "one value" : describe(wanted);
  problems.add(value.place, key, fmt::format("{} belongs here, not {}", name, describe(value)), std::string(hint));
  return false;
}

std::optional<graph::Name> read_name(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write a name", problems)) return std::nullopt;
  return graph::Name{value.text, value.place};
}

std::optional<std::vector<graph::Name>> read_names(const Value& value, const std::string& key, std::string_view hint,
                                                   Problems& problems) {
  if (!expect(value, ValueKind::kSequence, key, hint, problems)) return std::nullopt;
  std::vector<graph::Name> names;
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    if (auto name = read_name(value.items[i], fmt::format("{}[{}]", key, i), problems)) names.push_back(*name);
  }
  if (names.size() < value.items.size()) return std::nullopt;
  return names;
}

std::optional<bool> read_bool(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write true or false", problems)) return std::nullopt;
  if (!value.quoted && value.text == "true") return true;
  if (!value.quoted && value.text == "false") return false;
  problems.add(value.place, key, fmt::format("{} is neither true nor false", describe(value)), "write true or false");
  return std::nullopt;
}

std::optional<graph::At<int>> read_int(const Value& value, const std::string& key, int min, int max,
                                       Problems& problems) {
  const std::string hint = fmt::format("write a whole number from {} to {}", min, max);
  if (!expect_scalar(value, key, hint, problems)) return std::nullopt;
  int number = 0;
  const char* const end = value.text.data() + value.text.size();
  const auto [stop, status] = std::from_chars(value.text.data(), end, number);
  if (status == std::errc::invalid_argument || stop != end) {
    problems.add(value.place, key, fmt::format("{} is no whole number", describe(value)), hint);
    return std::nullopt;
  }
  if (status != std::errc{} || number < min || number > max) {
    problems.add(value.place, key, fmt::format("{} is out of range", describe(value)), hint);
    return std::nullopt;
  }
  return graph::At<int>{number, value.place};
}

std::optional<graph::At<double>> read_number(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write a number", problems)) return std::nullopt;
  double number = 0.0;
  const char* const end = value.text.data() + value.text.size();
  const auto [stop, status] = std::from_chars(value.text.data(), end, number);
  if (status == std::errc{} && stop == end && std::isfinite(number)) return graph::At<double>{number, value.place};
  problems.add(value.place, key, fmt::format("{} is no number", describe(value)), "write a number, without a unit");
  return std::nullopt;
}

std::optional<graph::At<Nanos>> read_duration(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write a duration, as in 20ms", problems)) return std::nullopt;
  const auto duration = parse_duration(value.text);
  if (duration) return graph::At<Nanos>{*duration, value.place};
  problems.add(value.place, key, duration.error());
  return std::nullopt;
}

std::optional<graph::At<Nanos>> read_positive_duration(const Value& value, const std::string& key, Problems& problems) {
  auto duration = read_duration(value, key, problems);
  if (!duration || duration->value > Nanos::zero()) return duration;
  problems.add(value.place, key, "0 is not allowed here", "write a duration of more than 0");
  return std::nullopt;
}

std::optional<graph::At<Rate>> read_rate(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write a rate, as in 50Hz", problems)) return std::nullopt;
  const auto rate = parse_rate(value.text);
  if (!rate) {
    problems.add(value.place, key, rate.error());
    return std::nullopt;
  }
  graph::At<Rate> result{*rate, value.place};
  return result;
}

std::optional<double> read_percentage(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write a percentage, as in 6%", problems)) return std::nullopt;
  const auto fraction = parse_percentage(value.text);
  if (fraction) return *fraction;
  problems.add(value.place, key, fraction.error());
  return std::nullopt;
}

std::optional<double> read_growth(const Value& value, const std::string& key, Problems& problems) {
  if (!expect_scalar(value, key, "write how much it grows each second, as in 0.5%/s", problems)) return std::nullopt;
  const auto growth = parse_growth(value.text);
  if (growth) return *growth;
  problems.add(value.place, key, growth.error());
  return std::nullopt;
}

std::optional<std::size_t> read_word(const Value& value, const std::string& key,
                                     std::span<const std::string_view> words, Problems& problems) {
  const std::string hint = "write " + list_words(words);
  if (!expect_scalar(value, key, hint, problems)) return std::nullopt;
  const auto found = std::find(words.begin(), words.end(), value.text);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  problems.add(value.place, key, fmt::format("{} is not known here", describe(value)), hint);
  return std::nullopt;
}

}  // namespace ctn::config
