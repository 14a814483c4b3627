#include "runtime/protocol.h"

#include <array>
#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

namespace ctn::runtime {
namespace {

using Json = nlohmann::json;

using Kind = Request::Kind;

constexpr std::array<std::pair<Kind, const char*>, 8> kNames{{{Kind::kHello, "hello"},
                                                              {Kind::kJoin, "join"},
                                                              {Kind::kAdd, "add"},
                                                              {Kind::kLeave, "leave"},
                                                              {Kind::kApp, "app"},
                                                              {Kind::kChange, "change"},
                                                              {Kind::kStatus, "status"},
                                                              {Kind::kFlight, "flight"}}};

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

bool has_node(Kind kind) { return kind == Kind::kJoin || kind == Kind::kAdd || kind == Kind::kLeave; }
bool has_thread(Kind kind) { return kind == Kind::kHello || kind == Kind::kJoin || kind == Kind::kAdd; }
bool has_version(Kind kind) { return !has_node(kind); }

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

Error answer_not_understood() {
  return Error::environment("the server's answer was not understood", "let the app and `catan` be of one version");
}

// The only member of an object, if it is one and has an object for a value.
std::optional<std::pair<std::string, Json>> only_entry(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || message.size() != 1 || !message.begin()->is_object()) return std::nullopt;
  return std::pair{message.begin().key(), *message.begin()};
}

// --- What is to change ---

Json pair_of(const std::string& name, const std::optional<double>& value) {
  return Json::array({name, value ? Json(*value) : Json(nullptr)});
}

void write_changes(const Changes& changes, Json& fields) {
  if (changes.cpus) fields["cpus"] = *changes.cpus;
  for (const Changes::Weight& change : changes.weights)
    fields["weights"].push_back(pair_of(change.term, change.weight));
  for (const Changes::Max& change : changes.maxes) fields["maxes"].push_back(pair_of(change.term, change.max_ms));
  for (const Changes::MinRate& change : changes.min_rates) {
    fields["min_rates"].push_back(pair_of(change.node, change.min_rate_hz));
  }
}

// Takes the pairs of a name and a number, or of a name and nothing where that is allowed. Nothing is read where there
// is no such list; then, too, it is as it should be.
template <class Take>
bool read_pairs(const Json& fields, const char* key, bool may_be_none, std::size_t& found_fields, const Take& take) {
  const auto found = fields.find(key);
  if (found == fields.end()) return true;
  ++found_fields;
  if (!found->is_array() || found->empty()) return false;
  for (const Json& pair : *found) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string()) return false;
    const bool none = may_be_none && pair[1].is_null();
    if (!none && !pair[1].is_number()) return false;
    take(pair[0].get<std::string>(), none ? std::nullopt : std::optional(pair[1].get<double>()));
  }
  return true;
}

bool read_cpus(const Json& fields, Changes& changes, std::size_t& found_fields) {
  const auto found = fields.find("cpus");
  if (found == fields.end()) return true;
  ++found_fields;
  if (!found->is_array()) return false;
  changes.cpus.emplace();
  for (const Json& cpu : *found) {
    constexpr std::int64_t kMaxCpus = 1 << 20;
    if (!cpu.is_number_integer() || cpu.get<std::int64_t>() < 0 || cpu.get<std::int64_t>() >= kMaxCpus) return false;
    changes.cpus->push_back(static_cast<int>(cpu.get<std::int64_t>()));
  }
  return true;
}

bool read_changes(const Json& fields, Changes& changes, std::size_t& found_fields) {
  const auto weight = [&](std::string term, std::optional<double> value) {
    changes.weights.push_back({std::move(term), value.value_or(0.0)});
  };
  const auto max = [&](std::string term, std::optional<double> value) {
    changes.maxes.push_back({std::move(term), value});
  };
  const auto min_rate = [&](std::string node, std::optional<double> value) {
    changes.min_rates.push_back({std::move(node), value});
  };
  return read_cpus(fields, changes, found_fields) && read_pairs(fields, "weights", false, found_fields, weight) &&
         read_pairs(fields, "maxes", true, found_fields, max) &&
         read_pairs(fields, "min_rates", true, found_fields, min_rate) && changes != Changes{};
}

// Names in it may be in no encoding at all.
std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

std::string to_text(const Request& request) {
  Json fields = Json::object();
  if (has_version(request.kind)) fields["version"] = request.version;
  if (has_node(request.kind)) fields["node"] = request.node;
  if (has_thread(request.kind)) fields["thread"] = request.thread;
  if (request.kind == Kind::kChange) write_changes(request.changes, fields);
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
  if (has_version(*kind)) {
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
  if (*kind == Kind::kChange) {
    if (!read_changes(fields, request.changes, expected)) return not_understood("it does not say what to change");
  }
  if (fields.size() != expected) return not_understood("it says more than is known");
  return request;
}

std::string to_text(const Status& reply) {
  if (reply) return dump({{"done", Json::object()}});
  std::string what;
  for (const Problem& problem : reply.error().problems()) {
    what += (what.empty() ? "" : "; ") + (problem.key.empty() ? "" : problem.key + ": ") + problem.what;
  }
  return dump({{"refused", {{"what", what}, {"hint", reply.error().problems().front().hint}}}});
}

Status parse_reply(std::string_view text) {
  const auto entry = only_entry(text);
  if (entry && entry->first == "done") return Done{};
  if (!entry || entry->first != "refused") return answer_not_understood();
  const auto read = [&](const char* key) {
    const auto found = entry->second.find(key);
    return found != entry->second.end() && found->is_string() ? found->get<std::string>() : std::string("?");
  };
  return Error::caller(read("what"), read("hint"));
}

std::string app_reply(const std::string& app) { return dump({{"done", {{"app", app}}}}); }

Result<std::string> parse_app_reply(std::string_view text) {
  if (Status told = parse_reply(text); !told) return told.error();
  const Json fields = only_entry(text)->second;
  const auto app = fields.find("app");
  if (app == fields.end() || !app->is_string()) return answer_not_understood();
  return app->get<std::string>();
}

}  // namespace ctn::runtime
