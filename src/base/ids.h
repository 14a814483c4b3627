// Typed indexes: a NodeId cannot be passed where a SubchainId is meant. Each indexes the vector of its kind in a graph.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace ctn {

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

}  // namespace ctn

template <class Tag>
struct std::hash<ctn::Id<Tag>> {
  std::size_t operator()(ctn::Id<Tag> id) const noexcept { return id.index(); }
};
