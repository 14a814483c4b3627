#include "plan/strict_json.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <set>

namespace ctn::plan {

void StrictJson::problem(std::string key, std::string what, std::string hint) {
  problems_.push_back({{file_, 0, 0}, std::move(key), std::move(what), std::move(hint)});
}

std::string StrictJson::child(const std::string& path, std::string_view key) {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

// JSON lets a key occur twice, and the library would keep the last in silence.
std::optional<StrictJson::Json> StrictJson::parse(std::string_view text) {
  struct Open {
    std::set<std::string> keys;
    std::string last;
  };
  std::vector<Open> open;  // the objects around what is being read
  const auto watch = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end) open.pop_back();
    if (event != Json::parse_event_t::key) return true;
    open.back().last = value.get<std::string>();
    if (open.back().keys.insert(open.back().last).second) return true;
    std::string path;
    for (const Open& object : open) path = child(path, object.last);
    problem(std::move(path), "the key is there twice in one object", "keep one");
    return true;
  };
  try {
    return Json::parse(text, watch);
  } catch (const Json::parse_error& error) {
    syntax_problem(text, error.byte, "the text is not JSON");
  } catch (const Json::out_of_range&) {
    syntax_problem(text, 0, "a number is too large");
  }
  return std::nullopt;
}

void StrictJson::syntax_problem(std::string_view text, std::size_t byte, std::string what) {
  Place place{file_, 0, 0};
  if (byte > 0) {
    const std::string_view before = text.substr(0, std::min(byte - 1, text.size()));
    place.line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
    place.column = static_cast<int>(before.size() - (before.rfind('\n') + 1)) + 1;
  }
  problems_.push_back({std::move(place), "", std::move(what), hint_});
}

// Arrays and objects by their kind only: a text may nest them deeper than writing them out could follow.
std::string StrictJson::shown(const Json& value) {
  if (value.is_structured()) return fmt::format("this {}", value.type_name());
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

bool StrictJson::object(const Json& value, const std::string& path, std::initializer_list<std::string_view> keys,
                        std::initializer_list<std::string_view> optional) {
  const auto is_in = [](std::initializer_list<std::string_view> list, std::string_view key) {
    return std::find(list.begin(), list.end(), key) != list.end();
  };
  if (!value.is_object()) {
    problem(path, fmt::format("this is {}, not an object", value.type_name()));
    return false;
  }
  for (const auto& [key, unused] : value.items()) {
    if (!is_in(keys, key) && !is_in(optional, key)) problem(child(path, key), "unknown key", "remove it");
  }
  for (const std::string_view key : keys) {
    if (!value.contains(key)) problem(child(path, key), "the key is missing");
  }
  return true;
}

const StrictJson::Json* StrictJson::member(const Json& value, std::string_view key) {
  const auto found = value.find(key);
  return found == value.end() ? nullptr : &*found;
}

void StrictJson::read_number(const Json& parent, const std::string& path, std::string_view key, double& out) {
  const Json* value = member(parent, key);
  if (!value) return;
  if (!value->is_number() || !std::isfinite(value->get<double>()) || value->get<double>() < 0.0) {
    problem(child(path, key), fmt::format("{} is no number from 0 up", shown(*value)));
    return;
  }
  out = value->get<double>();
}

void StrictJson::read_millis(const Json& parent, const std::string& path, std::string_view key, Millis& out) {
  double number = 0.0;
  read_number(parent, path, key, number);
  out = Millis{number};
}

std::optional<int> StrictJson::whole(const Json& value, const std::string& path) {
  if (value.is_number_integer() && value >= 0 && value <= INT_MAX) return value.get<int>();
  problem(path, fmt::format("{} is no whole number from 0 up", shown(value)));
  return std::nullopt;
}

void StrictJson::read_int(const Json& parent, const std::string& path, std::string_view key, int& out) {
  if (const Json* value = member(parent, key)) out = whole(*value, child(path, key)).value_or(0);
}

std::string StrictJson::read_text(const Json& parent, const std::string& path, std::string_view key) {
  const Json* value = member(parent, key);
  if (!value) return {};
  if (value->is_string()) return value->get<std::string>();
  problem(child(path, key), fmt::format("{} is no text", shown(*value)));
  return {};
}

}  // namespace ctn::plan
