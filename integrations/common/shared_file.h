// What the programs of an app tell each other, in a file that all of them map: tables whose entries are found by hash
// (hash.h). A new file is all zeros, which is what an entry is that nobody has written into; one that is there goes on.
//
// `Content` consists of atomics, and an entry has a member `std::atomic<std::uint64_t> hash{0}`; 0: it is free.
//
// Thread safety: all calls from any thread; wait-free, but for opening. What another program wrote is not trusted.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace catan_ros {

// At most so many nodes of an app are known to each other.
inline constexpr std::size_t kSharedNodes = 256;

// Of a file of that size, made if it is not there; without a path memory of this process alone. Null: it cannot be had,
// or the file is not this user's.
void* map_shared(const std::string& path, std::size_t size);
void unmap_shared(void* memory, std::size_t size);
// Whether this user has a file of that name, or can make it.
bool can_be_shared(const std::string& path);

template <class Content>
class SharedFile {
 public:
  static std::unique_ptr<SharedFile> open(const std::string& path) {
    void* const memory = map_shared(path, sizeof(Content));
    return memory != nullptr ? std::unique_ptr<SharedFile>(new SharedFile(*static_cast<Content*>(memory))) : nullptr;
  }
  ~SharedFile() { unmap_shared(&content_, sizeof(Content)); }
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  Content& content() const { return content_; }

 private:
  explicit SharedFile(Content& content) : content_(content) {}

  Content& content_;
};

// The entry of that hash, which is not 0; with `make`, a free one becomes it. Null: there is none, or the table is
// full.
template <class Entry, std::size_t Size>
Entry* find_entry(std::array<Entry, Size>& table, std::uint64_t hash, bool make) {
  for (std::size_t step = 0; step < Size; ++step) {
    Entry& entry = table[(hash + step) % Size];
    std::uint64_t there = entry.hash.load(std::memory_order_acquire);
    if (there == hash) return &entry;
    if (there != 0) continue;
    if (!make) return nullptr;
    if (entry.hash.compare_exchange_strong(there, hash) || there == hash) return &entry;
  }
  return nullptr;
}

}  // namespace catan_ros
