#include "web/change_request.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "runtime/protocol.h"

namespace ctn::web {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Deeper than any change. The library's parser does not recurse, but the destructor of the value that it makes does.
constexpr int kDeepest = 8;

Error not_a_change(const std::string& why) {
  return Error::caller("the change was not understood: " + why,
                       R"(send one such as {"weights": [["0", 0.5]]}; docs/http.md says more)");
}

// The JSON object that the text is; nothing: it is none, or is nested too deeply.
std::optional<OrderedJson> parse_object(std::string_view body) {
  bool too_deep = false;
  const auto watch_depth = [&](int depth, OrderedJson::parse_event_t, const OrderedJson&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  OrderedJson fields = OrderedJson::parse(body, watch_depth, false);
  if (too_deep || !fields.is_object()) return std::nullopt;
  return fields;
}

Result<Changes> change_of(OrderedJson fields) {
  if (fields.contains("version")) return not_a_change("it has a key that no change has");
  fields["version"] = runtime::kProtocolVersion;
  const std::string text =
      OrderedJson{{"change", std::move(fields)}}.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  Result<runtime::Request> request = runtime::parse_request(text);
  if (!request) return not_a_change("a key is unknown, or a value is of the wrong type");
  return std::move(request->changes);
}

Error not_a_question(const std::string& why) {
  return Error::caller("the question was not understood: " + why,
                       R"(send one such as {"costs": {"LM": "x2"}, "cores": 2}; docs/http.md says more)");
}

// Takes the value of `key` out; null: there is none.
OrderedJson taken_out(OrderedJson& fields, const char* key) {
  const auto found = fields.find(key);
  if (found == fields.end()) return nullptr;
  OrderedJson value = std::move(*found);
  fields.erase(found);
  return value;
}

}  // namespace

Result<Changes> parse_change(std::string_view body) {
  std::optional<OrderedJson> fields = parse_object(body);
  if (!fields) return not_a_change("it is not a JSON object");
  return change_of(std::move(*fields));
}

Result<WhatIf> parse_what_if(std::string_view body) {
  std::optional<OrderedJson> fields = parse_object(body);
  if (!fields) return not_a_question("it is not a JSON object");
  WhatIf asked;
  const OrderedJson costs = taken_out(*fields, "costs");
  if (!costs.is_null() && !costs.is_object()) return not_a_question("`costs` is not an object");
  for (const auto& [node, cost] : costs.items()) {
    if (!cost.is_string()) return not_a_question("a cost is not a text such as \"5ms\" or \"x2\"");
    asked.costs.push_back({node, cost.get<std::string>()});
  }
  const OrderedJson cores = taken_out(*fields, "cores");
  if (!cores.is_null()) {
    if (!cores.is_number_integer() || cores < 1 || cores > kMaxCoresAsked) {
      return not_a_question(fmt::format("`cores` is not a number from 1 to {}", kMaxCoresAsked));
    }
    asked.cores = cores.get<int>();
  }
  if (fields->empty()) return asked;
  Result<Changes> changes = change_of(std::move(*fields));
  if (!changes) return changes.error();
  asked.changes = std::move(*changes);
  return asked;
}

std::string error_json(std::string_view what, std::string_view hint) {
  return OrderedJson{{"error", what}, {"hint", hint}}.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) +
         "\n";
}

std::string error_json(const Error& error) {
  std::string what;
  for (const Problem& problem : error.problems()) {
    what += (what.empty() ? "" : "; ") + (problem.key.empty() ? "" : problem.key + ": ") + problem.what;
  }
  return error_json(what, error.problems().front().hint);
}

}  // namespace ctn::web
