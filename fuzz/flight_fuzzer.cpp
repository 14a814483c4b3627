// Memory of a flight recorder that any program may have written: opening it and reading events out of it ends in order,
// whatever is in it, and what is handed on could have happened in the app.
//
// The input is a memory as it is (where it begins with the layout's magic number), and the ring of one that is in
// order.
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "config/app_file.h"
#include "flight/layout.h"
#include "flight/recorder.h"
#include "flight/recording.h"
#include "os/linux/shared_memory.h"

namespace {

using namespace ctn;

constexpr const char* kApp = R"(catan: 1
app: fuzzed
nodes: { eye: { modes: [light, dark] }, hand: {}, lamp: { external: true, period: 8ms } }
edges: [ eye -> hand, hand -> lamp ]
objective: [ { response_time: [eye, hand], weight: 1 } ]
)";

struct Check : record::PartialSink {
  using PartialSink::add;
  explicit Check(const graph::App& of) : app(of) {}

  static void expect(bool holds) {
    if (!holds) std::abort();
  }
  void node(NodeId id) const { expect(id.index() < app.graph.nodes().size()); }
  void subchain(SubchainId id) const { expect(id.index() < app.graph.subchains().size()); }

  void add(const record::Run& run) override {
    node(run.node);
    expect(run.number > 0 && run.begin <= run.end);
    expect(run.mode < std::max<std::size_t>(app.graph.node(run.node).modes.size(), 1));
    for (const record::Consumed& input : run.consumed) {
      node(input.predecessor);
      expect(input.first > 0 && input.first <= input.last);
    }
  }
  void add(const record::Trigger& trigger) override { subchain(trigger.subchain); }
  void add(const record::SlotUse& slot) override {
    subchain(slot.subchain);
    expect(slot.core >= 0);
  }
  void add(const record::Steal& steal) override {
    subchain(steal.thief);
    subchain(steal.victim);
  }
  void add(const record::Overrun& overrun) override { subchain(overrun.subchain); }
  void add(const record::CostChange& change) override { node(change.node); }
  void add(const record::AppChange& change) override {
    const bool of_node = change.what == record::AppChange::What::kMinRate;
    expect(change.item < (of_node ? app.graph.nodes().size() : app.objective.size()));
  }
  void add(const record::ClockReading& reading) override {
    node(reading.node);
    expect(reading.ticks.period > Nanos{0});
  }

  const graph::App& app;
};

void read_all(const os::SharedMemory& memory) {
  auto recording = flight::Recording::open(*memory.read_only());
  if (!recording) return;
  Check check(recording->app());
  static_cast<void>(recording->read_new(check));
}

// The input as a whole memory. A memfd's size is sealed: one of the input's.
void open_anything(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return;
  auto memory = os::SharedMemory::create("fuzzed", size);
  if (!memory) return;
  std::memcpy(memory->bytes().data(), data, size);
  read_all(*memory);
}

// The input as words of a ring in a memory that is otherwise in order, made once.
void read_ring(const std::uint8_t* data, std::size_t size, const graph::App& app) {
  static const std::unique_ptr<flight::Recorder> recorder = *flight::Recorder::create(
      app, {}, os::ProcessId{static_cast<std::int32_t>(::getpid())}, flight::Recorder::kMinBytes);
  static const auto original = *os::ReadOnlyMemory::open(*recorder->readable());
  static const os::SharedMemory memory = *os::SharedMemory::create("fuzzed", original.bytes().size());
  std::memcpy(memory.bytes().data(), original.bytes().data(), original.bytes().size());
  auto* const head = reinterpret_cast<flight::Head*>(memory.bytes().data());
  const std::size_t ring = head->ring_words.load() * sizeof(flight::Word);
  const std::size_t words = std::min(size, ring) / sizeof(flight::Word);
  if (words > 0) {
    std::memcpy(memory.bytes().data() + memory.bytes().size() - ring, data, words * sizeof(flight::Word));
  }
  head->end.store(words);
  read_all(memory);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const graph::App app = *config::parse_app(kApp, "app.yaml");
  open_anything(data, size);
  read_ring(data, size, app);
  return 0;
}
