// YAML text -> a tree in which every value knows its place. The only code that touches the YAML library.
//
// What Catan's files have no use for is refused here, before or while the library reads it: more than 1 MiB, bytes that
// are not UTF-8, control characters, tabs that indent, anchors and aliases (so that no file can unfold into a bigger
// one), tags, nesting deeper than 16, keys that are not plain text, a second document.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ctn::config {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20U;

enum class ValueKind { kNull, kScalar, kSequence, kMap };

struct Entry;

struct Value {
  ValueKind kind = ValueKind::kNull;
  std::string text;  // of a scalar
  bool quoted = false;
  bool verbatim = false;  // the text stands in the file as it is here, on one line: column + i is the place of text[i]
  Place place;
  std::vector<Value> items;    // of a sequence
  std::vector<Entry> entries;  // of a map, as written, doubled keys and all
};

struct Entry {
  std::string key;
  Place place;
  Value value;
};

// "a map", "a list", "nothing" or "'text'": what an error says was found.
std::string describe(const Value& value);

// `help` is the page that describes the format. Never throws. Errors: kCaller, one problem.
Result<Value> parse_yaml(std::string_view text, std::string_view file, std::string_view help);

}  // namespace ctn::config
