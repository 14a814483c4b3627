#include "runtime/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

#include "runtime/report.h"

namespace ctn::runtime {
namespace {

constexpr std::size_t kLine = 64;

std::size_t to_whole_lines(std::size_t size) { return (size + kLine - 1) / kLine * kLine; }

template <class T>
std::span<T> view(std::span<std::byte> memory, std::size_t offset, std::size_t count) {
  return {std::launder(reinterpret_cast<T*>(memory.data() + offset)), count};
}

template <class T>
void construct(std::span<std::byte> memory, std::size_t offset, std::size_t count) {
  for (std::size_t index = 0; index < count; ++index) new (memory.data() + offset + index * sizeof(T)) T();
}

Error not_a_region(std::string what) {
  return Error::environment(std::move(what), "let the app and `catan` be of one version");
}

Result<RegionHeader> read_header(std::span<const std::byte> memory) {
  RegionHeader header;
  if (memory.size() < sizeof header) return not_a_region("the shared memory is too small for a region");
  std::memcpy(&header, memory.data(), sizeof header);
  if (header.magic != RegionHeader::kMagic) return not_a_region("the shared memory is not a region of Catan");
  if (header.version != RegionHeader::kVersion) {
    return not_a_region(fmt::format("the shared memory is of version {}, this program's of version {}", header.version,
                                    RegionHeader::kVersion));
  }
  if (header.size != memory.size() || header.text_size > memory.size() - sizeof header) {
    return not_a_region("the shared memory is not of the size that it says");
  }
  return header;
}

}  // namespace

void ControllerCell::wake(os::Threads& threads) {
  word.fetch_add(1, std::memory_order_release);
  threads.wake(word);
}

// Readers see either what stands for the number that they ask for, or that it does not: a reader of a newer word
// finds the number marked, or newer, when it looks at it again.
void NodeCell::give(std::uint64_t run, std::int64_t origin) {
  Output& output = outputs[run % kOutputs];
  output.number.store(run | Output::kWriting, std::memory_order_relaxed);
  output.origin.store(origin, std::memory_order_release);
  output.previous.store(newest_output.load(std::memory_order_relaxed), std::memory_order_release);
  output.number.store(run, std::memory_order_release);
  newest_output.store(run, std::memory_order_release);
}

NodeCell::Found NodeCell::find(std::uint64_t run) const {
  const Output& output = outputs[run % kOutputs];
  if (output.number.load(std::memory_order_acquire) != run) return {};
  const std::int64_t origin = output.origin.load(std::memory_order_acquire);
  const std::uint64_t previous = output.previous.load(std::memory_order_acquire);
  if (output.number.load(std::memory_order_relaxed) != run) return {};
  return {std::max<std::int64_t>(origin, 0), previous};
}

// From the newest backwards: between two outputs there may be any number of runs that gave none. Any of them may be the
// oldest, since a node that reads an input only now and then goes back further when it does.
std::int64_t NodeCell::oldest_origin(std::uint64_t first, std::uint64_t last) const {
  std::int64_t oldest = std::numeric_limits<std::int64_t>::max();
  for (std::size_t step = 0; step < kOutputs; ++step) {
    const Found found = find(last);
    if (found.origin == kUnknown) return kUnknown;
    oldest = std::min(oldest, found.origin);
    if (found.previous < first) return oldest;
    if (found.previous >= last) return kUnknown;  // it lies
    last = found.previous;
  }
  return kUnknown;
}

namespace {

constexpr std::uint64_t kController = (std::uint64_t{1} << OutputCell::kControllerBits) - 1;

// What a subscriber waits for is a few outputs away. More of them are none that will come: the count is beyond it, or
// has fallen back, since others may have overwritten it.
constexpr std::uint64_t kFarAway = 4096;

// Whether a subscriber is to look at the count. Of what it waits for only the lower bits are known.
bool is_to_look(std::uint64_t count, std::uint64_t subscriber) {
  const std::uint64_t left = (subscriber & ~kController) - (count << OutputCell::kControllerBits);
  return left == 0 || left > kFarAway << OutputCell::kControllerBits;
}

}  // namespace

// Sequentially consistent on both sides: a controller subscribes, then looks at the count. So either this thread sees
// it, or the controller sees the output before it sleeps.
void OutputCell::give_output(os::Threads& threads_to_wake, const Region& region, TimePoint at) {
  newest_output.store(at.time_since_epoch().count(), std::memory_order_relaxed);
  const std::uint64_t count = outputs.fetch_add(1, std::memory_order_seq_cst) + 1;
  for (const std::atomic<std::uint64_t>& each : subscribers) {
    const std::uint64_t subscriber = each.load(std::memory_order_seq_cst);
    const std::uint64_t controller = subscriber & kController;
    if (controller == 0 || controller > region.controller_cells() || !is_to_look(count, subscriber)) continue;
    region.controller_cell(controller - 1).wake(threads_to_wake);
  }
}

bool OutputCell::subscribe(std::size_t controller, std::uint64_t count) {
  const std::uint64_t number = controller + 1;
  const std::uint64_t own = count << kControllerBits | number;
  for (std::atomic<std::uint64_t>& subscriber : subscribers) {
    const std::uint64_t found = subscriber.load(std::memory_order_seq_cst);
    if ((found & kController) != number) continue;
    if (found != own) subscriber.store(own, std::memory_order_seq_cst);
    return true;
  }
  for (std::atomic<std::uint64_t>& subscriber : subscribers) {
    std::uint64_t free = 0;
    if (subscriber.compare_exchange_strong(free, own, std::memory_order_seq_cst)) return true;
  }
  return false;
}

void OutputCell::unsubscribe(std::size_t controller) {
  for (std::atomic<std::uint64_t>& subscriber : subscribers) {
    std::uint64_t found = subscriber.load(std::memory_order_seq_cst);
    if ((found & kController) == controller + 1) {
      subscriber.compare_exchange_strong(found, 0, std::memory_order_seq_cst);
    }
  }
}

// Offsets in bytes from the region's start.
struct Region::Layout {
  Layout(const graph::Graph& graph, std::size_t cores, std::size_t text_size)
      : controller_count(graph.subchains().size() + cores) {
    heartbeat = to_whole_lines(sizeof(RegionHeader) + text_size);
    controller_cells = heartbeat + sizeof(Heartbeat);
    signals = controller_cells + controller_count * sizeof(ControllerCell);
    nodes = signals + graph.subchains().size() * sizeof(SignalCell);
    std::size_t end = nodes + graph.nodes().size() * sizeof(NodeCell);
    for (const graph::Node& node : graph.nodes()) {
      rings.push_back(end);
      if (node.external) continue;
      const std::size_t words = kReports * report_words(node.predecessors.size());
      end += sizeof(RingHeader) + to_whole_lines(words * sizeof(std::uint64_t));
    }
    size = end;
  }

  std::size_t controller_count;
  std::size_t heartbeat = 0;
  std::size_t controller_cells = 0;
  std::size_t signals = 0;
  std::size_t nodes = 0;
  std::vector<std::size_t> rings;  // by NodeId
  std::size_t size = 0;
};

std::size_t Region::size_for(const graph::Graph& graph, std::size_t cores, std::string_view text) {
  return Layout(graph, cores, text.size()).size;
}

Region::Region(const graph::Graph& graph, const Layout& layout, std::span<std::byte> memory)
    : heartbeat_(view<Heartbeat>(memory, layout.heartbeat, 1).data()),
      controller_cells_(view<ControllerCell>(memory, layout.controller_cells, layout.controller_count)),
      signals_(view<SignalCell>(memory, layout.signals, graph.subchains().size())),
      nodes_(view<NodeCell>(memory, layout.nodes, graph.nodes().size())) {
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    const graph::Node& node = graph.nodes()[index];
    Ring& ring = rings_.emplace_back();
    if (node.external) continue;
    ring.stride = report_words(node.predecessors.size());
    ring.header = view<RingHeader>(memory, layout.rings[index], 1).data();
    ring.words = view<std::uint64_t>(memory, layout.rings[index] + sizeof(RingHeader), kReports * ring.stride);
  }
}

Region Region::create(const graph::Graph& graph, std::size_t cores, std::string_view text, std::span<std::byte> memory,
                      bool cut) {
  const Layout layout(graph, cores, text.size());
  assert(memory.size() == layout.size);
  RegionHeader header;
  header.cores = static_cast<std::uint32_t>(cores);
  header.size = layout.size;
  header.text_size = text.size();
  header.cut = cut ? 1 : 0;
  std::memcpy(memory.data(), &header, sizeof header);
  if (!text.empty()) std::memcpy(memory.data() + sizeof header, text.data(), text.size());
  construct<Heartbeat>(memory, layout.heartbeat, 1);
  construct<ControllerCell>(memory, layout.controller_cells, layout.controller_count);
  construct<SignalCell>(memory, layout.signals, graph.subchains().size());
  construct<NodeCell>(memory, layout.nodes, graph.nodes().size());
  for (std::size_t index = 0; index < graph.nodes().size(); ++index) {
    if (!graph.nodes()[index].external) construct<RingHeader>(memory, layout.rings[index], 1);
  }
  return {graph, layout, memory};
}

Result<std::string> Region::text(std::span<const std::byte> memory) {
  const Result<RegionHeader> header = read_header(memory);
  if (!header) return header.error();
  return std::string(reinterpret_cast<const char*>(memory.data()) + sizeof(RegionHeader), header->text_size);
}

Result<bool> Region::is_cut(std::span<const std::byte> memory) {
  const Result<RegionHeader> header = read_header(memory);
  if (!header) return header.error();
  return header->cut != 0;
}

Result<Region> Region::open(const graph::Graph& graph, std::span<std::byte> memory) {
  const Result<RegionHeader> header = read_header(memory);
  if (!header) return header.error();
  constexpr std::uint32_t kMaxCores = 65536;
  if (header->cores > kMaxCores) return not_a_region("the shared memory is for more cores than there can be");
  const Layout layout(graph, header->cores, header->text_size);
  if (layout.size != memory.size()) return not_a_region("the shared memory is not laid out for its app");
  return Region(graph, layout, memory);
}

RingWriter Region::reports_writer(NodeId node) const {
  const Ring& ring = rings_[node.index()];
  return {*ring.header, ring.words, ring.stride};
}

RingReader Region::reports_reader(NodeId node) const {
  const Ring& ring = rings_[node.index()];
  return {*ring.header, ring.words, ring.stride};
}

LocalRegion::LocalRegion(const graph::Graph& graph, std::size_t cores)
    : memory_(to_whole_lines(Region::size_for(graph, cores, {})) / sizeof(Line)),
      region_(Region::create(graph, cores, {},
                             std::as_writable_bytes(std::span(memory_)).first(Region::size_for(graph, cores, {})))) {}

}  // namespace ctn::runtime
