#include "config/illixr_binding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/text.h"
#include "config/collected_callbacks.h"
#include "config/read.h"

namespace ctn::config {
namespace {

constexpr std::array<std::string_view, 3> kIllixrKeys{"plugin", "topic", "output"};
constexpr std::string_view kIllixrHint =
    "write it as in {plugin: offline_imu}, for its threadloop, or {plugin: rk4_integrator, topic: imu}";

// Fields of what programs are told end with blanks.
std::optional<std::string> check_illixr_name(const std::optional<graph::Name>& name, const std::string& key,
                                             Problems& problems) {
  if (!name) return std::nullopt;
  const std::string& text = name->value;
  const bool fits =
      std::none_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) <= ' ' || c == ','; });
  if (fits && text != "-") return text;
  problems.add(name->place, key, fmt::format("{} is no name of a plugin or topic", quote(text)),
               "write it as the plugin's source does, without blanks and commas");
  return std::nullopt;
}

std::optional<std::string> read_illixr_name(const Value& value, const std::string& key, Problems& problems) {
  return check_illixr_name(read_name(value, key, problems), key, problems);
}

void read_outputs(const Value& value, const std::string& key, IllixrCallback& callback, Problems& problems) {
  const auto names = read_names(value, key, "write a list of topics, as in output: [cam]", problems);
  if (!names) return;
  for (const graph::Name& name : *names) {
    if (std::optional<std::string> topic = check_illixr_name(name, key, problems)) {
      callback.outputs.push_back(std::move(*topic));
    }
  }
}

}  // namespace

std::optional<IllixrCallback> read_illixr_callback(const Value& value, const std::string& key, Problems& problems) {
  if (!expect(value, ValueKind::kMap, key, kIllixrHint, problems)) return std::nullopt;
  const MapReader map(value, key, kIllixrKeys, problems);
  const Value* const plugin = map.find("plugin");
  const Value* const topic = map.find("topic");
  if (plugin == nullptr) {
    problems.add(value.place, key, "the plugin is missing", std::string(kIllixrHint));
    return std::nullopt;
  }
  IllixrCallback callback;
  callback.place = value.place;
  std::optional<std::string> name = read_illixr_name(*plugin, map.key_of("plugin"), problems);
  if (!name) return std::nullopt;
  callback.plugin = std::move(*name);
  if (const Value* output = map.find("output")) read_outputs(*output, map.key_of("output"), callback, problems);
  if (topic == nullptr) return callback;
  name = read_illixr_name(*topic, map.key_of("topic"), problems);
  if (!name) return std::nullopt;
  callback.topic = std::move(*name);
  return callback;
}

std::vector<IllixrBinding> read_illixr_bindings(const Value& root, const graph::App& app, Problems& problems) {
  CollectedCallbacks<IllixrCallback> collected("illixr", read_illixr_callback, app, problems);
  collected.add_app_file(root);
  return collected.take();
}

Result<std::vector<IllixrBinding>> illixr_bindings(std::string_view app_text, std::string_view file,
                                                   const graph::App& app) {
  return callbacks_of_app_file<IllixrCallback>(app_text, file, app, "illixr", read_illixr_callback);
}

}  // namespace ctn::config
