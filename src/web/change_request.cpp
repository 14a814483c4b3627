#include "web/change_request.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "runtime/protocol.h"

namespace ctn::web {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Deeper than any change is; the library's parser needs no stack, but what it makes does when it is destroyed.
constexpr int kDeepest = 8;

Error not_a_change(const std::string& why) {
  return Error::caller("the change was not understood: " + why,
                       R"(send one such as {"weights": [["0", 0.5]]}; docs/http.md says more)");
}

}  // namespace

Result<Changes> parse_change(std::string_view body) {
  bool too_deep = false;
  const auto watch_depth = [&](int depth, OrderedJson::parse_event_t, const OrderedJson&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  OrderedJson fields = OrderedJson::parse(body, watch_depth, false);
  if (too_deep || !fields.is_object()) return not_a_change("it is no JSON object");
  if (fields.contains("version")) return not_a_change("it says more than is known");
  fields["version"] = runtime::kProtocolVersion;
  const std::string text =
      OrderedJson{{"change", std::move(fields)}}.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
  Result<runtime::Request> request = runtime::parse_request(text);
  if (!request) return not_a_change("a key or a value is not as it should be");
  return std::move(request->changes);
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
