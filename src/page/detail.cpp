#include "page/detail.h"

#include <algorithm>

#include "page/buckets.h"

namespace ctn::page {
namespace {

constexpr std::size_t kCells = 2048;
constexpr std::size_t kWorst = 20;   // responses of each chain
constexpr std::size_t kEvents = 40;  // of each kind

// About how many bytes each takes on the page.
constexpr std::size_t kRunBytes = 14;
constexpr std::size_t kTriggerBytes = 7;
constexpr std::size_t kSlotBytes = 9;

std::vector<std::size_t> costs(const Story& story) {
  std::vector<std::size_t> cost(kCells);
  const auto add = [&](Micros at, std::size_t bytes) { cost[bucket_of(at, story.duration, kCells)] += bytes; };
  for (const RunSpan& run : story.runs) add(run.begin, kRunBytes);
  for (const auto& triggers : story.triggers) {
    for (const TriggerPoint& trigger : triggers) add(trigger.sent, kTriggerBytes);
  }
  for (const SlotSpan& slot : story.slots) add(slot.begin, kSlotBytes);
  for (const StealSpan& steal : story.steals) add(steal.slot.begin, kSlotBytes);
  return cost;
}

std::vector<std::size_t> wanted_cells(const Story& story) {
  std::vector<std::size_t> cells;
  const auto cell = [&](Micros at) {
    return bucket_of(std::clamp<Micros>(at, 0, story.duration), story.duration, kCells);
  };
  std::vector<std::vector<ResponsePoint>> worst;
  for (const auto& responses : story.responses) worst.push_back(worst_responses(responses, kWorst));
  for (std::size_t rank = 0; rank < kWorst; ++rank) {
    for (const auto& responses : worst) {
      if (rank >= responses.size()) continue;
      const ResponsePoint& response = responses[rank];
      const std::size_t last = cell(response.end);
      for (std::size_t i = cell(response.end - static_cast<Micros>(1e3 * response.response_ms)); i <= last; ++i) {
        cells.push_back(i);
      }
    }
    if (rank == 0) cells.push_back(0);
  }
  std::vector<std::size_t> seen(5);
  for (const Event& event : story.events) {
    if (++seen[static_cast<std::size_t>(event.kind)] > kEvents) continue;
    const std::size_t at = cell(event.at);
    cells.push_back(at);
    if (at + 1 < kCells) cells.push_back(at + 1);
  }
  return cells;
}

}  // namespace

std::vector<bool> choose(std::span<const std::size_t> cost, std::span<const std::size_t> wanted, std::size_t budget) {
  std::vector<bool> chosen(cost.size());
  std::size_t used = 0;
  const auto take = [&](std::size_t cell) {
    if (chosen[cell] || cost[cell] > budget - used) return;
    chosen[cell] = true;
    used += cost[cell];
  };
  for (const std::size_t cell : wanted) take(cell);
  for (std::size_t cell = 0; cell < cost.size(); ++cell) take(cell);
  return chosen;
}

bool Detail::has(Micros at) const { return cells[bucket_of(at, duration, cells.size())]; }

bool Detail::whole() const {
  return std::all_of(cells.begin(), cells.end(), [](bool chosen) { return chosen; });
}

Micros Detail::covered() const {
  return duration / static_cast<Micros>(cells.size()) * std::count(cells.begin(), cells.end(), true);
}

std::vector<Micros> Detail::windows() const {
  std::vector<Micros> windows;
  const auto edge = [&](std::size_t cell) {
    return static_cast<Micros>(static_cast<double>(duration) * static_cast<double>(cell) /
                               static_cast<double>(cells.size()));
  };
  bool inside = false;
  for (std::size_t i = 0; i <= cells.size(); ++i) {
    const bool chosen = i < cells.size() && cells[i];
    if (chosen != inside) windows.push_back(edge(i));
    inside = chosen;
  }
  return windows;
}

Detail choose_detail(const Story& story, std::size_t budget) {
  return {story.duration, choose(costs(story), wanted_cells(story), budget)};
}

std::vector<ResponsePoint> worst_responses(std::span<const ResponsePoint> responses, std::size_t count) {
  std::vector<ResponsePoint> worst(std::min(count, responses.size()));
  std::partial_sort_copy(responses.begin(), responses.end(), worst.begin(), worst.end(),
                         [](const auto& a, const auto& b) { return a.response_ms > b.response_ms; });
  return worst;
}

}  // namespace ctn::page
