#include "runtime/protocol.h"

#include <array>
#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

namespace ctn::runtime {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::pair<Request::Kind, const char*>, 4> kNames{{{Request::Kind::kHello, "hello"},
                                                                       {Request::Kind::kJoin, "join"},
                                                                       {Request::Kind::kAdd, "add"},
                                                                       {Request::Kind::kLeave, "leave"}}};

const char* name_of(Request::Kind kind) {
  for (const auto& [known, name] : kNames) {
    if (known == kind) return name;
  }
  return "";
}

std::optional<Request::Kind> kind_of(std::string_view name) {
  for (const auto& [kind, known] : kNames) {
    if (name == known) return kind;
  }
  return std::nullopt;
}

Error not_understood(const std::string& why) {
  return Error::caller("a message was not understood: " + why, "use a client library of the server's version");
}

bool has_node(Request::Kind kind) { return kind != Request::Kind::kHello; }
bool has_thread(Request::Kind kind) { return kind != Request::Kind::kLeave; }

bool read_number(const Json& fields, const char* key, std::int32_t& number) {
  const auto found = fields.find(key);
  if (found == fields.end() || !found->is_number_integer()) return false;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() > std::numeric_limits<std::int32_t>::max()) {
    return false;
  }
  const auto value = found->get<std::int64_t>();
  if (value < 1 || value > std::numeric_limits<std::int32_t>::max()) return false;
  number = static_cast<std::int32_t>(value);
  return true;
}

// The only member of an object, if it is one and has an object for a value.
std::optional<std::pair<std::string, Json>> only_entry(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || message.size() != 1 || !message.begin()->is_object()) return std::nullopt;
  return std::pair{message.begin().key(), *message.begin()};
}

// Names in it may be in no encoding at all.
std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string to_text(const Request& request) {
  Json fields = Json::object();
  if (request.kind == Request::Kind::kHello) fields["version"] = request.version;
  if (has_node(request.kind)) fields["node"] = request.node;
  if (has_thread(request.kind)) fields["thread"] = request.thread;
  return dump({{name_of(request.kind), fields}});
}

Result<Request> parse_request(std::string_view text) {
  const auto entry = only_entry(text);
  if (!entry) return not_understood("it is not an object with one object in it");
  const auto& [name, fields] = *entry;
  const std::optional<Request::Kind> kind = kind_of(name);
  if (!kind) return not_understood("there is no such request");

  Request request;
  request.kind = *kind;
  std::size_t expected = 0;
  if (*kind == Request::Kind::kHello) {
    ++expected;
    if (!read_number(fields, "version", request.version)) return not_understood("it has no version");
  }
  if (has_node(*kind)) {
    ++expected;
    const auto node = fields.find("node");
    if (node == fields.end() || !node->is_string()) return not_understood("it names no node");
    request.node = node->get<std::string>();
  }
  if (has_thread(*kind)) {
    ++expected;
    if (!read_number(fields, "thread", request.thread)) return not_understood("it names no thread");
  }
  if (fields.size() != expected) return not_understood("it says more than is known");
  return request;
}

std::string to_text(const Status& reply) {
  if (reply) return dump({{"done", Json::object()}});
  std::string what;
  for (const Problem& problem : reply.error().problems()) what += (what.empty() ? "" : "; ") + problem.what;
  return dump({{"refused", {{"what", what}, {"mend", reply.error().problems().front().hint}}}});
}

Status parse_reply(std::string_view text) {
  const auto entry = only_entry(text);
  if (entry && entry->first == "done") return Done{};
  if (!entry || entry->first != "refused") {
    return Error::environment("the server's answer was not understood", "let the app and `catan` be of one version");
  }
  const auto read = [&](const char* key) {
    const auto found = entry->second.find(key);
    return found != entry->second.end() && found->is_string() ? found->get<std::string>() : std::string("?");
  };
  return Error::caller(read("what"), read("mend"));
}

}  // namespace ctn::runtime
