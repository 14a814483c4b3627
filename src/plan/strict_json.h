// Strict access to a JSON text: each value is looked at where a schema expects it, each problem is noted under its JSON
// path, and reading goes on, so that all problems are reported at once. Where a value is of another kind, reading it
// gives nothing: 0, an empty text.
//
// Thread safety: none; one owner.
#pragma once

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/result.h"
#include "base/time.h"

namespace ctn::plan {

class StrictJson {
 public:
  using Json = nlohmann::json;

  // `file`: for the places of problems. `hint`: where a problem has none of its own.
  StrictJson(std::string_view file, const char* hint) : file_(file), hint_(hint) {}

  // Nothing where it is no JSON, which is noted, as is a key that an object has twice.
  std::optional<Json> parse(std::string_view text);

  void problem(std::string key, std::string what, std::string hint);
  void problem(std::string key, std::string what) { problem(std::move(key), std::move(what), hint_); }
  bool has_problems() const { return !problems_.empty(); }
  std::vector<Problem> take_problems() { return std::exchange(problems_, {}); }

  static std::string child(const std::string& path, std::string_view key);
  // A value as messages show it.
  static std::string shown(const Json& value);

  // Whether `value` is an object; that it has just these keys, and perhaps some of the `optional` ones, is checked on
  // the way.
  bool object(const Json& value, const std::string& path, std::initializer_list<std::string_view> keys,
              std::initializer_list<std::string_view> optional = {});
  // The member, or none (already reported by `object`).
  static const Json* member(const Json& value, std::string_view key);

  void read_number(const Json& parent, const std::string& path, std::string_view key, double& out);
  void read_millis(const Json& parent, const std::string& path, std::string_view key, Millis& out);
  std::optional<int> whole(const Json& value, const std::string& path);
  void read_int(const Json& parent, const std::string& path, std::string_view key, int& out);
  std::string read_text(const Json& parent, const std::string& path, std::string_view key);
  // Calls `each(element, path)` for the elements of the array under `key`.
  template <class Each>
  void read_array(const Json& parent, const std::string& path, std::string_view key, Each each) {
    const Json* value = member(parent, key);
    if (!value) return;
    const std::string here = child(path, key);
    if (!value->is_array()) return problem(here, fmt::format("this is {}, not an array", value->type_name()));
    for (std::size_t i = 0; i < value->size(); ++i) each((*value)[i], fmt::format("{}[{}]", here, i));
  }

 private:
  void syntax_problem(std::string_view text, std::size_t byte, std::string what);

  std::string file_;
  const char* hint_;
  std::vector<Problem> problems_;
};

}  // namespace ctn::plan
