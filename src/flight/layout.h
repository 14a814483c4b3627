// How the memory of a flight recorder is laid out, for its writer (recorder.h) and its readers (recording.h).
//
//   Head     how long the parts are, and how far the ring was written
//   image    a record in which nothing has happened (record::Writer::blank): the app and what else was known at first
//   ring     events as frames of words, oldest first, where the newest overwrite the oldest. A frame is its length,
//            this word included, and the event (event_words.h). Positions count the words that were ever written; the
//            word at position p lies at p modulo the ring's length
//
// A frame is valid from `oldest` to `end`, both of which are positions at which one begins. The writer raises `oldest`
// before it overwrites what was there, and `end` when the new frame is whole. A reader copies words, and then looks at
// `oldest` again: what lies before it may have been overwritten meanwhile, and is thrown away. For that the ring's
// words are stored with release and loaded with acquire: a reader that finds a new word also finds the `oldest` before
// it.
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

constexpr const char* kMemoryName = "catan-flight:";  // and the name of the app
constexpr Word kMagic = 0x3154484746544143;           // "CATFGHT1" and so the layout's version included

struct Head {
  SharedWord magic;  // written last: before it is there, nothing else is
  SharedWord image_bytes;
  SharedWord ring_words;
  SharedWord process;
  SharedWord alive_ns;  // when the writer last showed that it lives
  SharedWord over;      // 1: it has ended in order
  alignas(64) SharedWord oldest;
  SharedWord end;
};

// Words that so many bytes take.
constexpr std::size_t words_for(std::size_t bytes) { return (bytes + sizeof(Word) - 1) / sizeof(Word); }

// The parts of a memory, of which the image has so many bytes. Precondition: it is long enough for head and image, and
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
