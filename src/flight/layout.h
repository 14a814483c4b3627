// How the memory of a flight recorder is laid out, for its writer (recorder.h) and its readers (recording.h).
//
//   head     the lengths of the parts, signs of life of the writer, and how far the ring has been written
//   image    a record without events (record::Writer::blank): the app and what else was known at the start
//   ring     events as entries of words, oldest first; the newest overwrite the oldest. An entry is its length in words
//            (this one included), followed by the event (event_words.h). A position is a count of all words written
//            since the start; the word at position p lies at p modulo the ring's length
//
// The entries between `oldest` and `end` are valid; both are positions where one begins or ends. The writer raises
// `oldest` before it overwrites an entry, and `end` once the new one is complete. A reader copies words, then loads
// `oldest` again and throws away what lies before it, since that may have been overwritten meanwhile. This works
// because the ring's words are stored with release and loaded with acquire: a reader that sees a new word also sees the
// `oldest` that was stored before it.
//
// Thread safety: all words are atomic; one writer, any number of readers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "flight/event_words.h"

namespace ctn::flight {

using SharedWord = std::atomic<Word>;
static_assert(SharedWord::is_always_lock_free && sizeof(SharedWord) == sizeof(Word));

constexpr const char* kMemoryName = "catan-flight:";  // followed by the name of the app
constexpr Word kMagic = 0x3154484746544143;           // "CATFGHT1", which includes the version of the layout

struct Head {
  SharedWord magic;  // stored last: where it is not there yet, nor is the rest
  SharedWord image_bytes;
  SharedWord ring_words;
  SharedWord process;
  SharedWord alive_ns;  // when the writer last showed that it lives
  SharedWord over;      // 1: the run has ended in order
  alignas(64) SharedWord oldest;
  SharedWord end;
};

// How many words it takes to hold that many bytes.
constexpr std::size_t words_for(std::size_t bytes) { return (bytes + sizeof(Word) - 1) / sizeof(Word); }

// Where the parts lie in `memory`. Precondition: it is long enough for the head and an image of `image_bytes`, and
// aligned as Head is.
template <class Byte>
struct Parts {
  static constexpr bool kConst = std::is_const_v<Byte>;
  using HeadType = std::conditional_t<kConst, const Head, Head>;
  using WordType = std::conditional_t<kConst, const SharedWord, SharedWord>;

  Parts(std::span<Byte> memory, std::size_t image_bytes)
      : head(reinterpret_cast<HeadType*>(memory.data())),
        image(memory.subspan(sizeof(Head), image_bytes)),
        ring(reinterpret_cast<WordType*>(memory.data() + sizeof(Head) + words_for(image_bytes) * sizeof(Word)),
             (memory.size() - sizeof(Head)) / sizeof(Word) - words_for(image_bytes)) {}

  HeadType* head;
  std::span<Byte> image;
  std::span<WordType> ring;
};

}  // namespace ctn::flight
