// At which levels and on which cores the nodes' threads run, and whose turn it is in an exclusive group: who waits for
// a thread raises its level.
#include <algorithm>

#include "sim/nodes.h"

namespace ctn::sim {

// --- Levels and cores ---

void Nodes::set_level(SubchainId subchain, os::Level level) {
  for (const NodeId id : app_.graph.subchain(subchain).nodes) {
    Node& node = nodes_[id.index()];
    for (int helper = 0; helper <= node.helpers; ++helper) set_level_of(node, helper, level_of(level));
  }
}

void Nodes::set_levels(SubchainId subchain, const policy::SubchainPlace& place) {
  const std::vector<NodeId>& ids = app_.graph.subchain(subchain).nodes;
  for (std::size_t position = 0; position < ids.size(); ++position) {
    Node& node = nodes_[ids[position].index()];
    const Reservation reservation = reservations_.empty() ? Reservation{} : reservations_[ids[position].index()];
    const bool reserved = real_time_ && reservation.runtime > Nanos{0};
    for (int helper = 0; helper <= node.helpers; ++helper) {
      if (reserved) {
        cpus_.reserve(node.thread + static_cast<Cpus::Thread>(helper), reservation.runtime, reservation.period);
      } else {
        set_level_of(node, helper, level_of(place.level_of(position)));
      }
    }
  }
}

void Nodes::move(SubchainId subchain, const os::CpuSet& cpus) {
  const CpuMask mask(cpus);
  for (const NodeId id : app_.graph.subchain(subchain).nodes) {
    const Node& node = nodes_[id.index()];
    for (int helper = 0; helper <= node.helpers; ++helper) {
      cpus_.set_cpus(node.thread + static_cast<Cpus::Thread>(helper), mask);
    }
  }
}

Nanos Nodes::cpu_time(SubchainId subchain) {
  Nanos total{0};
  for (const NodeId id : app_.graph.subchain(subchain).nodes) {
    const Node& node = nodes_[id.index()];
    for (int helper = 0; helper <= node.helpers; ++helper) {
      total += cpus_.used_by(node.thread + static_cast<Cpus::Thread>(helper));
    }
  }
  return total;
}

void Nodes::set_level_of_unscheduled(os::Level level) {
  for (Node& node : nodes_) {
    if (!node.described->unscheduled || node.described->external) continue;
    for (int helper = 0; helper <= node.helpers; ++helper) set_level_of(node, helper, level_of(level));
  }
}

// --- Exclusive groups ---

// Null: the node is in none.
Nodes::Exclusion* Nodes::exclusion_of(const Node& node) {
  return node.described->exclusive ? &exclusions_[*node.described->exclusive] : nullptr;
}

// False: its run is to wait until the exclusive group is its own.
bool Nodes::enter(Node& node) {
  Exclusion* const exclusion = exclusion_of(node);
  if (exclusion == nullptr || exclusion->holder == node.id.index()) return true;
  if (!exclusion->holder) {
    exclusion->holder = node.id.index();
    if (!exclusion->waiting.empty()) raise_holder(*exclusion);
    return true;
  }
  exclusion->waiting.push_back(node.id.index());
  raise_holder(*exclusion);
  return false;
}

void Nodes::leave(Node& node, int cpu) {
  Exclusion* const exclusion = exclusion_of(node);
  if (exclusion == nullptr) return;
  exclusion->holder.reset();
  if (cpus_.level(node.thread) != Cpus::kReserved) cpus_.set_level(node.thread, node.level);
  const auto next = std::max_element(
      exclusion->waiting.begin(), exclusion->waiting.end(),
      [&](std::size_t a, std::size_t b) { return cpus_.level(nodes_[a].thread) < cpus_.level(nodes_[b].thread); });
  if (next == exclusion->waiting.end()) return;
  // It asks again when it has a CPU, as with a mutex of Linux: a higher one may be first.
  const std::size_t chosen = *next;
  exclusion->waiting.erase(next);
  cpus_.wake(nodes_[chosen].thread, cpu);
}

bool Nodes::waits_for_exclusion(const Node& node) {
  const Exclusion* const exclusion = exclusion_of(node);
  return exclusion != nullptr &&
         std::find(exclusion->waiting.begin(), exclusion->waiting.end(), node.id.index()) != exclusion->waiting.end();
}

// A thread that others wait for has a higher one until its run has ended.
void Nodes::set_level_of(Node& node, int helper, Cpus::LevelNumber level) {
  if (helper == 0) node.level = level;
  const Exclusion* const exclusion = helper == 0 ? exclusion_of(node) : nullptr;
  if (exclusion != nullptr && exclusion->holder == node.id.index() && !exclusion->waiting.empty()) {
    return raise_holder(*exclusion);
  }
  cpus_.set_level(node.thread + static_cast<Cpus::Thread>(helper), level);
  if (exclusion != nullptr && waits_for_exclusion(node)) raise_holder(*exclusion);
}

void Nodes::raise_holder(const Exclusion& exclusion) {
  const Node& holder = nodes_[*exclusion.holder];
  if (cpus_.level(holder.thread) == Cpus::kReserved) return;
  Cpus::LevelNumber level = holder.level;
  for (const std::size_t waiting : exclusion.waiting) {
    level = std::max(level, std::min(cpus_.level(nodes_[waiting].thread), Cpus::kReserved - 1));
  }
  cpus_.set_level(holder.thread, level);
}

}  // namespace ctn::sim
