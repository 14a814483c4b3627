// When what happens next: a binary heap over a fixed number of sources, each of which has at most one time at which it
// is due. No allocation once made. Of sources that are due at the same instant the one with the lower number comes
// first, so a simulation takes the same course everywhere.
//
// Units: TimePoint. Thread safety: none; one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/time.h"

namespace ctn::sim {

class EventQueue {
 public:
  using Source = std::uint32_t;

  explicit EventQueue(std::size_t sources) : position_(sources, kNowhere) { heap_.reserve(sources); }

  // kNever: it is due no more.
  void set(Source source, TimePoint at) {
    const std::uint32_t position = position_[source];
    if (at == kNever) {
      if (position != kNowhere) remove(position);
    } else if (position == kNowhere) {
      heap_.push_back({at, source});
      rise(heap_.size() - 1);
    } else {
      const TimePoint before = std::exchange(heap_[position].at, at);
      at < before ? rise(position) : sink(position);
    }
  }

  TimePoint next() const { return heap_.empty() ? kNever : heap_.front().at; }
  // Precondition: next() is not kNever.
  Source pop() {
    const Source source = heap_.front().source;
    remove(0);
    return source;
  }

  TimePoint time_of(Source source) const {
    return position_[source] == kNowhere ? kNever : heap_[position_[source]].at;
  }

 private:
  static constexpr std::uint32_t kNowhere = 0xffffffff;
  struct Entry {
    TimePoint at;
    Source source;
    friend bool operator<(const Entry& a, const Entry& b) {
      return a.at < b.at || (a.at == b.at && a.source < b.source);
    }
  };

  void put(std::size_t position, const Entry& entry) {
    heap_[position] = entry;
    position_[entry.source] = static_cast<std::uint32_t>(position);
  }
  void rise(std::size_t position) {
    const Entry entry = heap_[position];
    while (position > 0) {
      const std::size_t parent = (position - 1) / 2;
      if (!(entry < heap_[parent])) break;
      put(position, heap_[parent]);
      position = parent;
    }
    put(position, entry);
  }
  void sink(std::size_t position) {
    const Entry entry = heap_[position];
    for (std::size_t child = 2 * position + 1; child < heap_.size(); child = 2 * position + 1) {
      if (child + 1 < heap_.size() && heap_[child + 1] < heap_[child]) ++child;
      if (!(heap_[child] < entry)) break;
      put(position, heap_[child]);
      position = child;
    }
    put(position, entry);
  }
  void remove(std::size_t position) {
    position_[heap_[position].source] = kNowhere;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (position == heap_.size()) return;
    const bool earlier = last < heap_[position];  // compared with what it replaces
    put(position, last);
    earlier ? rise(position) : sink(position);
  }

  std::vector<Entry> heap_;
  std::vector<std::uint32_t> position_;  // by source, in the heap
};

}  // namespace ctn::sim
