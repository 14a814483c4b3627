#include "config/app_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "config/app_reader.h"
#include "config/illixr_binding.h"
#include "config/problems.h"
#include "config/ros_binding.h"
#include "config/yaml.h"
#include "graph/build.h"

namespace ctn::config {

Result<graph::App> parse_app(std::string_view text, std::string_view file, RunBy run_by) {
  const auto root = parse_yaml(text, file, "docs/app-file.md");
  if (!root) return root.error();
  Problems problems;
  AppReader reader(*root, problems);
  const graph::AppSpec spec = reader.read();
  if (!reader.all_read()) return std::move(problems).to_error();
  auto app = graph::build_app(spec);
  if (!app) problems.merge(app.error());
  if (problems.empty()) {
    const std::vector<RosBinding> bindings = read_ros_bindings(*root, *app, problems);
    if (run_by == RunBy::kBoundPrograms) app->graph = app->graph.needing_input(nodes_needing_input(bindings));
  }
  if (problems.empty()) static_cast<void>(read_illixr_bindings(*root, *app, problems));
  if (!problems.empty()) return std::move(problems).to_error();
  return app;
}

Result<graph::App> load_app(const std::string& path, RunBy run_by) {
  Result<AppFile> file = load_app_file(path, run_by);
  if (!file) return file.error();
  return std::move(file->app);
}

Result<AppFile> load_app_file(const std::string& path, RunBy run_by) {
  Result<std::string> text = read_text(path);
  if (!text) return text.error();
  Result<graph::App> app = parse_app(*text, path, run_by);
  if (!app) return app.error();
  return AppFile{std::move(*text), std::move(*app)};
}

Result<std::string> read_text(const std::string& path) {
  const auto fault = [&](std::string what, std::string hint) {
    return Error(ErrorKind::kCaller, {{{path, 0, 0}, "", std::move(what), std::move(hint)}});
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return fault("is a directory", "name a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return fault(fmt::format("cannot be read: {}", std::strerror(errno)), "check the path and its rights");
  std::string text(kMaxBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return fault(fmt::format("cannot be read: {}", std::strerror(errno)), "check the file");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kMaxBytes) return fault(fmt::format("has more than {} bytes", kMaxBytes), "is it the right file?");
  return text;
}

}  // namespace ctn::config
