#include "flight/event_words.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "base/ids.h"
#include "base/time.h"

namespace ctn::flight {
namespace {

constexpr std::int64_t kLongest = std::int64_t{1} << 61;  // instant or duration that a record takes, in ns
constexpr int kMaxCores = 1 << 20;

enum class Kind : Word {
  kRun = 1,
  kTrigger,
  kSlotUse,
  kSteal,
  kOverrun,
  kPlanChange,
  kCostChange,
  kAppChange,
  kClockReading,
  kNotice,
  kTotals
};

// Puts values into words.
class Put {
 public:
  explicit Put(Kind kind) {
    words_.reserve(kRoom);
    words_.push_back(static_cast<Word>(kind));
  }

  void number(std::uint64_t value) { words_.push_back(value); }
  void operator()(std::uint64_t value) { number(value); }
  void operator()(std::uint32_t value) { number(value); }
  void operator()(bool value) { number(value ? 1 : 0); }
  void operator()(int value) { number(static_cast<std::uint64_t>(std::int64_t{value})); }
  void operator()(Nanos value) { number(static_cast<std::uint64_t>(value.count())); }
  void operator()(TimePoint value) { (*this)(value.time_since_epoch()); }
  void operator()(NodeId value) { number(value.index()); }
  void operator()(SubchainId value) { number(value.index()); }
  void operator()(const std::optional<double>& value) {
    (*this)(value.has_value());
    number(std::bit_cast<std::uint64_t>(value.value_or(0.0)));
  }
  void operator()(const std::string& text) {
    number(text.size());
    const std::size_t first = words_.size();
    words_.resize(first + (text.size() + sizeof(Word) - 1) / sizeof(Word));
    if (!text.empty()) std::memcpy(words_.data() + first, text.data(), text.size());
  }
  std::vector<Word> take() { return std::move(words_); }

 private:
  static constexpr std::size_t kRoom = 64;  // for a run with a few inputs, in one allocation

  std::vector<Word> words_;
};

// Gets values from words, and refuses those that Put cannot have written.
class Get {
 public:
  Get(std::span<const Word> words, const graph::App& app) : words_(words), app_(app) {}

  bool ok() const { return ok_; }
  // Whether all words were read, and none was refused.
  bool complete() const { return ok_ && words_.empty(); }
  void refuse() { ok_ = false; }
  const graph::App& app() const { return app_; }

  std::uint64_t number() {
    if (words_.empty()) {
      refuse();
      return 0;
    }
    const Word word = words_.front();
    words_ = words_.subspan(1);
    return word;
  }
  std::uint64_t number_up_to(std::uint64_t max) {
    const std::uint64_t value = number();
    if (value <= max) return value;
    refuse();
    return 0;
  }
  // Numbers of runs and triggers. Integers in the database are signed.
  void operator()(std::uint64_t& value) { value = number_up_to(std::numeric_limits<std::int64_t>::max()); }
  void operator()(std::uint32_t& value) {
    value = static_cast<std::uint32_t>(number_up_to(std::numeric_limits<std::uint32_t>::max()));
  }
  void operator()(bool& value) { value = number_up_to(1) != 0; }
  void operator()(int& value) {
    const auto read = static_cast<std::int64_t>(number());
    if (read < -1 || read > kMaxCores) refuse();
    value = ok_ ? static_cast<int>(read) : 0;
  }
  void operator()(Nanos& value) {
    value = Nanos{static_cast<std::int64_t>(number_up_to(static_cast<std::uint64_t>(kLongest)))};
  }
  void operator()(TimePoint& value) {
    Nanos since{};
    (*this)(since);
    value = TimePoint{since};
  }
  void operator()(NodeId& value) { value = NodeId{index(app_.graph.nodes().size())}; }
  void operator()(SubchainId& value) { value = SubchainId{index(app_.graph.subchains().size())}; }
  void operator()(std::optional<double>& value) {
    bool is_there = false;
    (*this)(is_there);
    const double read = std::bit_cast<double>(number());
    if (!std::isfinite(read)) refuse();
    value = is_there && ok_ ? std::optional(read) : std::nullopt;
  }
  void operator()(std::string& text) {
    const std::uint64_t size = number_up_to(words_.size() * sizeof(Word));
    const std::uint64_t words = (size + sizeof(Word) - 1) / sizeof(Word);
    if (!ok_ || words > words_.size()) return refuse();
    text.resize(size);
    if (size > 0) std::memcpy(text.data(), words_.data(), size);
    words_ = words_.subspan(words);
  }
  std::size_t index(std::size_t size) {
    const std::uint64_t value = number();
    if (value < size) return value;
    refuse();
    return 0;
  }
  bool has_mode(NodeId node, std::uint32_t mode) const {
    return mode < std::max<std::size_t>(app_.graph.node(node).modes.size(), 1);
  }
  std::size_t words_left() const { return words_.size(); }

 private:
  std::span<const Word> words_;
  const graph::App& app_;
  bool ok_ = true;
};

// --- The fields of each kind, in order: the same code puts and gets them. An event that is put is const ---

template <class Way>
constexpr bool kPuts = std::is_same_v<std::remove_reference_t<Way>, Put>;

constexpr auto kRunWords = [](auto& way, auto& run) {
  way(run.node), way(run.number), way(run.begin), way(run.end), way(run.cpu), way(run.mode), way(run.emitted);
  way(run.on_cpu), way(run.wait);
  if constexpr (kPuts<decltype(way)>) {
    way.number(run.consumed.size());
  } else {
    constexpr std::size_t kWordsOfEach = 3;
    const std::uint64_t count = way.number_up_to(way.words_left() / kWordsOfEach);
    if (way.ok()) run.consumed.resize(count);
    if (run.number == 0 || run.begin > run.end || !way.has_mode(run.node, run.mode)) way.refuse();
  }
  for (auto& input : run.consumed) {
    way(input.predecessor), way(input.first), way(input.last);
    if constexpr (!kPuts<decltype(way)>) {
      if (input.first == 0 || input.first > input.last) way.refuse();
    }
  }
};

constexpr auto kTriggerWords = [](auto& way, auto& trigger) {
  way(trigger.subchain), way(trigger.number), way(trigger.due), way(trigger.sent);
  if constexpr (!kPuts<decltype(way)>) {
    if (trigger.number == 0) way.refuse();
  }
};

constexpr auto kSlotWords = [](auto& way, auto& slot) {
  way(slot.core), way(slot.subchain), way(slot.planned), way(slot.begin), way(slot.end);
  if constexpr (!kPuts<decltype(way)>) {
    if (slot.core < 0) way.refuse();
  }
};

constexpr auto kStealWords = [](auto& way, auto& steal) {
  way(steal.core), way(steal.thief), way(steal.victim), way(steal.begin), way(steal.end);
  if constexpr (!kPuts<decltype(way)>) {
    if (steal.core < 0) way.refuse();
  }
};

constexpr auto kOverrunWords = [](auto& way, auto& overrun) {
  way(overrun.subchain), way(overrun.number), way(overrun.at), way(overrun.cpu);
  if constexpr (!kPuts<decltype(way)>) {
    if (overrun.number == 0) way.refuse();
  }
};

constexpr auto kPlanWords = [](auto& way, auto& change) { way(change.at), way(change.reason), way(change.json); };

constexpr auto kCostWords = [](auto& way, auto& change) {
  way(change.at), way(change.node), way(change.mode), way(change.core_kind), way(change.before), way(change.after);
  way(change.runs);
  if constexpr (!kPuts<decltype(way)>) {
    if (change.runs == 0 || change.core_kind < 0 || !way.has_mode(change.node, change.mode)) way.refuse();
  }
};

constexpr auto kAppChangeWords = [](auto& way, auto& change) {
  using What = record::AppChange::What;
  way(change.at);
  if constexpr (kPuts<decltype(way)>) {
    way.number(static_cast<Word>(change.what));
    way.number(change.item);
  } else {
    change.what = static_cast<What>(way.number_up_to(static_cast<Word>(What::kMinRate)));
    change.item =
        way.index(change.what == What::kMinRate ? way.app().graph.nodes().size() : way.app().objective.size());
  }
  way(change.before), way(change.after);
  if constexpr (!kPuts<decltype(way)>) {
    if (change.what == What::kWeight && !change.after) way.refuse();
  }
};

constexpr auto kClockWords = [](auto& way, auto& reading) {
  way(reading.at), way(reading.node), way(reading.ticks.tick), way(reading.ticks.period);
  if constexpr (!kPuts<decltype(way)>) {
    if (reading.ticks.period <= Nanos{0} || !way.app().graph.node(reading.node).has_clock()) way.refuse();
  }
};

constexpr auto kNoticeWords = [](auto& way, auto& notice) { way(notice.at), way(notice.kind), way(notice.detail); };

constexpr auto kTotalsWords = [](auto& way, auto& totals) {
  way(totals.plans_made), way(totals.planning_cpu), way(totals.starved), way(totals.starved_for);
};

template <class Event, class Words>
std::vector<Word> put(Kind kind, const Event& event, const Words& words) {
  Put way(kind);
  words(way, event);
  return way.take();
}

template <class Event, class Words>
bool get(Get& way, const Words& words, record::Sink& to) {
  Event event;
  words(way, event);
  if (!way.complete()) return false;
  if constexpr (std::is_same_v<Event, record::Totals>) {
    to.set_totals(event);
  } else {
    to.add(event);
  }
  return true;
}

}  // namespace

std::vector<Word> to_words(const record::Run& event) { return put(Kind::kRun, event, kRunWords); }
std::vector<Word> to_words(const record::Trigger& event) { return put(Kind::kTrigger, event, kTriggerWords); }
std::vector<Word> to_words(const record::SlotUse& event) { return put(Kind::kSlotUse, event, kSlotWords); }
std::vector<Word> to_words(const record::Steal& event) { return put(Kind::kSteal, event, kStealWords); }
std::vector<Word> to_words(const record::Overrun& event) { return put(Kind::kOverrun, event, kOverrunWords); }
std::vector<Word> to_words(const record::PlanChange& event) { return put(Kind::kPlanChange, event, kPlanWords); }
std::vector<Word> to_words(const record::CostChange& event) { return put(Kind::kCostChange, event, kCostWords); }
std::vector<Word> to_words(const record::AppChange& event) { return put(Kind::kAppChange, event, kAppChangeWords); }
std::vector<Word> to_words(const record::ClockReading& event) { return put(Kind::kClockReading, event, kClockWords); }
std::vector<Word> to_words(const record::Notice& event) { return put(Kind::kNotice, event, kNoticeWords); }
std::vector<Word> to_words(const record::Totals& totals) { return put(Kind::kTotals, totals, kTotalsWords); }

bool hand_on(std::span<const Word> words, const graph::App& app, record::Sink& to) {
  Get way(words, app);
  switch (static_cast<Kind>(way.number())) {
    case Kind::kRun:
      return get<record::Run>(way, kRunWords, to);
    case Kind::kTrigger:
      return get<record::Trigger>(way, kTriggerWords, to);
    case Kind::kSlotUse:
      return get<record::SlotUse>(way, kSlotWords, to);
    case Kind::kSteal:
      return get<record::Steal>(way, kStealWords, to);
    case Kind::kOverrun:
      return get<record::Overrun>(way, kOverrunWords, to);
    case Kind::kPlanChange:
      return get<record::PlanChange>(way, kPlanWords, to);
    case Kind::kCostChange:
      return get<record::CostChange>(way, kCostWords, to);
    case Kind::kAppChange:
      return get<record::AppChange>(way, kAppChangeWords, to);
    case Kind::kClockReading:
      return get<record::ClockReading>(way, kClockWords, to);
    case Kind::kNotice:
      return get<record::Notice>(way, kNoticeWords, to);
    case Kind::kTotals:
      return get<record::Totals>(way, kTotalsWords, to);
  }
  return false;
}

}  // namespace ctn::flight
