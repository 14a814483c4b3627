#include "flight/recorder.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace ctn::flight {
namespace {

constexpr std::size_t kLongestName = 200;  // of an app, as part of the memory's name
constexpr std::size_t kPartOfAnEvent = 8;  // an event takes less than this part of the ring
constexpr int kRounds = 4;  // writing kept events again may overwrite others of them: how often to go over them

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::create(const graph::App& app, const record::Header& header,
                                                   os::ProcessId process, std::size_t bytes) {
  const Result<std::vector<std::byte>> image = record::Writer::blank(app, header);
  if (!image) return image.error();
  const std::size_t ring = words_for(std::max(bytes, kMinBytes));
  const std::size_t size = sizeof(Head) + (words_for(image->size()) + ring) * sizeof(Word);
  Result<os::SharedMemory> memory = os::SharedMemory::create(kMemoryName + app.name.substr(0, kLongestName), size);
  if (!memory) return memory.error();
  std::unique_ptr<Recorder> recorder(new Recorder(std::move(*memory), image->size()));
  std::memcpy(recorder->parts_.image.data(), image->data(), image->size());
  Head& head = *recorder->parts_.head;
  head.image_bytes.store(image->size(), std::memory_order_relaxed);
  head.ring_words.store(recorder->parts_.ring.size(), std::memory_order_relaxed);
  head.process.store(static_cast<Word>(process), std::memory_order_relaxed);
  recorder->show_alive(header.started);
  head.magic.store(kMagic, std::memory_order_release);
  return recorder;
}

Recorder::Recorder(os::SharedMemory memory, std::size_t image_bytes)
    : memory_(std::move(memory)), parts_(memory_.bytes(), image_bytes) {}

void Recorder::add(const record::AppChange& change) {
  using Of = record::AppChange::What;
  const What what = change.what == Of::kWeight ? What::kWeight : change.what == Of::kMax ? What::kMax : What::kMinRate;
  keep({what, change.item}, to_words(change));
}

void Recorder::set_totals(const record::Totals& totals) {
  if (totals == totals_) return;
  totals_ = totals;
  keep({What::kTotals, 0}, to_words(totals));
}

void Recorder::show_alive(TimePoint now) {
  parts_.head->alive_ns.store(static_cast<Word>(now.time_since_epoch().count()), std::memory_order_relaxed);
}

bool Recorder::fits(const std::vector<Word>& event) const { return event.size() < parts_.ring.size() / kPartOfAnEvent; }

void Recorder::push(const std::vector<Word>& event) {
  if (!fits(event)) return;
  write(event);
  write_kept_again();
}

void Recorder::keep(const Subject& subject, std::vector<Word> event) {
  if (!fits(event)) {
    kept_.erase(subject);
    return;
  }
  const Kept& kept = kept_[subject] = {std::move(event), end_};
  write(kept.event);
  write_kept_again();
}

// By an event of the largest size and all that holds.
bool Recorder::may_be_overwritten_next(Word position) const {
  if (position < oldest_) return true;
  const Word room = parts_.ring.size() - (end_ - oldest_) + (position - oldest_);
  return room < 2 * (parts_.ring.size() / kPartOfAnEvent);
}

void Recorder::write_kept_again() {
  bool wrote = true;
  for (int round = 0; wrote && round < kRounds; ++round) {
    wrote = false;
    for (auto& [subject, kept] : kept_) {
      if (!may_be_overwritten_next(kept.position)) continue;
      kept.position = end_;
      write(kept.event);
      wrote = true;
    }
  }
}

void Recorder::write(const std::vector<Word>& event) {
  const std::size_t length = event.size() + 1;
  make_room(length);
  const auto put = [this](Word position, Word word) {
    parts_.ring[position % parts_.ring.size()].store(word, std::memory_order_release);
  };
  put(end_, length);
  for (std::size_t index = 0; index < event.size(); ++index) put(end_ + 1 + index, event[index]);
  end_ += length;
  entries_.push_back(length);
  parts_.head->end.store(end_, std::memory_order_release);
}

void Recorder::make_room(std::size_t words) {
  while (end_ + words - oldest_ > parts_.ring.size()) {
    oldest_ += entries_.front();
    entries_.pop_front();
  }
  parts_.head->oldest.store(oldest_, std::memory_order_release);
}

}  // namespace ctn::flight
