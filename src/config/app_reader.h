// The YAML tree of an app file -> AppSpec: the shape of the file. What the names mean is graph::build_app's to check.
#pragma once

#include <optional>
#include <string>

#include "config/problems.h"
#include "config/read.h"
#include "config/yaml.h"
#include "graph/spec.h"

namespace ctn::config {

class AppReader {
 public:
  AppReader(const Value& root, Problems& problems) : root_(root), problems_(problems) {}

  graph::AppSpec read();

  // False where a section could not be read at all: what it would have named is not known, and checking the rest
  // against it would only report the same mistake again and again.
  bool all_read() const { return all_read_; }

 private:
  void read_version(const MapReader& map);
  void read_app_name(const MapReader& map);
  void read_cores(const MapReader& map);
  void read_nodes(const MapReader& map);
  graph::NodeSpec read_node(const Entry& entry, const std::string& key);
  void read_edges(const MapReader& map);
  std::optional<graph::PathSpec> read_edge(const Value& value, const std::string& key);
  std::optional<graph::PathSpec> read_path(const Value& value, const std::string& key);
  void read_subchains(const MapReader& map);
  void read_exclusive(const MapReader& map);
  void read_objective(const MapReader& map);
  std::optional<graph::TermSpec> read_term(const Value& value, const std::string& key);
  void read_order(const MapReader& map);
  void read_steal(const MapReader& map);
  void read_scheduler(const MapReader& map);

  const Value& root_;
  Problems& problems_;
  graph::AppSpec spec_;
  bool all_read_ = true;
};

}  // namespace ctn::config
