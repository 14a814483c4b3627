// The work behind `build_app`: one pass a section of the spec, each adding what it finds wrong to one list, so that a
// developer sees everything at once. A pass never trusts what an earlier one rejected: a name that did not resolve is
// skipped, so that one mistake is reported once.
//
// Cost: near linear in the size of the spec, whatever it holds. Thread safety: local to one call.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/result.h"
#include "graph/app.h"
#include "graph/spec.h"

namespace ctn::graph {

class AppBuilder {
 public:
  explicit AppBuilder(const AppSpec& spec) : spec_(spec) {}
  Result<App> build();

 private:
  using SubchainNames = std::unordered_map<std::string_view, SubchainId>;
  struct WrittenEdge {
    Edge edge;
    std::size_t path;                         // index into spec_.edges
    Place place;                              // of the node it leads to
    std::optional<std::size_t> limited_by{};  // index into spec_.edges: of the entry that gave its age limit
  };

  // build.cpp
  void add_core_kinds();

  // build_nodes.cpp
  void add_nodes();
  void check_kind(const NodeSpec& spec, const std::string& key);
  void check_values(const NodeSpec& spec, const std::string& key);
  void check_modes(const NodeSpec& spec, const std::string& key);
  bool check_name(const Name& name, const std::string& key, std::string_view of_what);
  static bool is_name(const Name& name);

  // build_edges.cpp
  void add_edges();
  void add_path(std::size_t index);
  bool check_age_limit(const PathSpec& path, const std::string& key);
  void limit_age(WrittenEdge& written, std::size_t path, const std::string& key);
  void check_cycles();
  void report_cycle(const std::vector<NodeId>& trail, const WrittenEdge& closing);
  void sort_topologically();
  void complete_periods();

  // build_subchains.cpp
  void add_subchains();
  bool add_member(SubchainId id, const Name& name, const std::string& key);
  void check_subchain_path(const SubchainSpec& spec, const std::string& key);
  void add_implicit_subchains();
  void check_rates(const Subchain& subchain);
  void check_fallback_rates(const Subchain& subchain);
  void check_name_of_part(const NodeSpec& spec);
  void report_fallback_above_max(const NodeSpec& sets_rate, const NodeSpec& bounded);
  void check_triggers(const Subchain& subchain);
  void add_exclusive_groups();
  bool add_exclusive(std::size_t group, const Name& name, const std::string& key);

  // build_objective.cpp
  void add_objective();
  std::optional<Term> resolve_term(const TermSpec& spec, const std::string& key);
  bool check_term_path(const TermSpec& spec, const std::vector<NodeId>& path, const std::string& key);
  void add_order();
  std::vector<SubchainId> resolve_ranking(const std::vector<Name>& names, const std::string& key);
  std::optional<SubchainId> resolve_subchain(const Name& name, const std::string& key);

  std::optional<NodeId> resolve_node(const Name& name, const std::string& key);
  void problem(const Place& place, std::string_view key, std::string_view what, std::string_view hint);
  void problem(const Place& place, const std::optional<Problem>& found) {
    if (found) problem(place, found->key, found->what, found->hint);
  }
  std::string guess(std::string_view word, const std::vector<std::string>& candidates, std::string otherwise) const;
  bool has_edge(NodeId from, NodeId to) const { return edge_index_.contains({from, to}); }
  // An edge that is missing may be the one that was misspelt: then it was reported.
  bool lacks_edge(NodeId from, NodeId to) const {
    return !has_edge(from, to) && !open_ends_.contains(from) && !open_ends_.contains(to);
  }
  const std::string& name_of(NodeId id) const { return app_.graph.node(id).name; }

  const AppSpec& spec_;
  App app_;
  std::vector<Problem> problems_;
  std::vector<const NodeSpec*> node_specs_;  // by NodeId
  std::vector<std::string> node_names_;      // by NodeId
  std::unordered_map<std::string_view, NodeId> node_index_;
  std::vector<WrittenEdge> written_edges_;
  std::map<std::pair<NodeId, NodeId>, std::size_t> edge_index_;  // into written_edges_
  std::set<NodeId> open_ends_;                                   // whose neighbour in a path is not known
  std::vector<std::string> subchain_names_;                      // by SubchainId
  SubchainNames subchain_index_;
};

}  // namespace ctn::graph
