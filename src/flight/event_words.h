// Events as rows of 64-bit words, as the memory of a flight recorder keeps them, and back.
//
// Units: as record/events.h. Thread safety: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graph/app.h"
#include "record/events.h"
#include "record/sink.h"

namespace ctn::flight {

using Word = std::uint64_t;

// The first word is the kind of the event. What records do not keep of a run is left out.
std::vector<Word> to_words(const record::Run& event);
std::vector<Word> to_words(const record::Trigger& event);
std::vector<Word> to_words(const record::SlotUse& event);
std::vector<Word> to_words(const record::Steal& event);
std::vector<Word> to_words(const record::Overrun& event);
std::vector<Word> to_words(const record::PlanChange& event);
std::vector<Word> to_words(const record::CostChange& event);
std::vector<Word> to_words(const record::AppChange& event);
std::vector<Word> to_words(const record::ClockReading& event);
std::vector<Word> to_words(const record::Notice& event);
std::vector<Word> to_words(const record::Totals& totals);

// Hands on the event that the words stand for. False, and nothing is handed on: no event of this app looks like that.
bool hand_on(std::span<const Word> words, const graph::App& app, record::Sink& to);

}  // namespace ctn::flight
