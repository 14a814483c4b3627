// Typed indexes: a NodeId cannot be passed where a SubchainId is meant. Each indexes the vector of its kind in a graph.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace catan {

template <class Tag>
class Id {
 public:
  constexpr Id() = default;
  explicit constexpr Id(std::size_t index) : index_(static_cast<std::uint32_t>(index)) {}
  constexpr std::size_t index() const { return index_; }
  friend constexpr auto operator<=>(Id, Id) = default;

 private:
  std::uint32_t index_ = 0;
};

using NodeId = Id<struct NodeTag>;
using SubchainId = Id<struct SubchainTag>;

}  // namespace catan

template <class Tag>
struct std::hash<catan::Id<Tag>> {
  std::size_t operator()(catan::Id<Tag> id) const noexcept { return id.index(); }
};
