// Reading typed values out of the YAML tree. Every function adds what is wrong to `problems`, under the key it is
// given, and returns nothing then: the caller goes on, so that all problems are found.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "config/problems.h"
#include "config/yaml.h"
#include "graph/spec.h"

namespace ctn::config {

// A map whose keys are fixed: doubled and unknown ones are problems. Keeps references to its arguments.
class MapReader {
 public:
  // `path` is the key of the map itself, empty for the whole file.
  MapReader(const Value& map, std::string path, std::span<const std::string_view> known, Problems& problems);

  // The value of a key; none where it was not written.
  const Value* find(std::string_view key) const;
  std::string key_of(std::string_view key) const;

 private:
  const Value& map_;
  std::string path_;
};

// "nodes" + "GL" -> "nodes.GL".
std::string join_key(std::string_view path, std::string_view key);

// The entries of a map whose keys are names that the user chose; of a doubled one the first.
std::vector<const Entry*> read_entries(const Value& map, const std::string& key, Problems& problems);

// Whether it is of that kind; `hint` says how to write it.
bool expect(const Value& value, ValueKind kind, const std::string& key, std::string_view hint, Problems& problems);

std::optional<graph::Name> read_name(const Value& value, const std::string& key, Problems& problems);
// A list of names. One bad item makes the whole list unusable: what it would have meant is not known.
std::optional<std::vector<graph::Name>> read_names(const Value& value, const std::string& key, std::string_view hint,
                                                   Problems& problems);
std::optional<bool> read_bool(const Value& value, const std::string& key, Problems& problems);
std::optional<graph::At<int>> read_int(const Value& value, const std::string& key, int min, int max,
                                       Problems& problems);
// A plain decimal number, finite; the range is the caller's to check.
std::optional<graph::At<double>> read_number(const Value& value, const std::string& key, Problems& problems);
std::optional<graph::At<Nanos>> read_duration(const Value& value, const std::string& key, Problems& problems);
std::optional<graph::At<Nanos>> read_positive_duration(const Value& value, const std::string& key, Problems& problems);
std::optional<graph::At<Rate>> read_rate(const Value& value, const std::string& key, Problems& problems);
std::optional<double> read_percentage(const Value& value, const std::string& key, Problems& problems);
std::optional<double> read_growth(const Value& value, const std::string& key, Problems& problems);
// One of a few words; its index in `words`.
std::optional<std::size_t> read_word(const Value& value, const std::string& key,
                                     std::span<const std::string_view> words, Problems& problems);

}  // namespace ctn::config
