// Memory that any program may have written: opening it as a region, and reading reports out of it, ends in order,
// whatever is in it; and what is believed of the reports is a history that could have been.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "config/app_file.h"
#include "os/fake/fake_os.h"
#include "runtime/node_link.h"
#include "runtime/region.h"
#include "runtime/report_check.h"

namespace {

using namespace ctn;

constexpr const char* kApp = R"(catan: 1
app: fuzzed
nodes: { eye: { modes: [light, dark] }, hand: {} }
edges: [ eye -> hand ]
objective: [ { response_time: [eye, hand], weight: 1 } ]
)";

void open_anything(const std::uint8_t* data, std::size_t size, const graph::Graph& graph) {
  std::vector<std::uint64_t> memory((size + 7) / 8);
  if (size > 0) std::memcpy(memory.data(), data, size);
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(memory)).first(size);
  if (const auto text = runtime::Region::text(bytes)) static_cast<void>(config::parse_app(*text, "region"));
  static_cast<void>(runtime::Region::open(graph, bytes));
}

// The input as reports of a node.
void read_reports(const std::uint8_t* data, std::size_t size, const graph::App& app) {
  static os::FakeOs fake{os::fake_topology(1)};
  runtime::LocalRegion memory(app.graph, 1);
  runtime::NodeLink link(fake, app.graph, NodeId(1), memory.region());
  runtime::RingWriter writer = memory.region().reports_writer(NodeId(1));
  runtime::ReportCheck check(app.graph);
  const std::size_t words = runtime::report_words(1);
  std::vector<std::uint64_t> report(words);
  std::uint64_t number = 0;
  TimePoint end{};
  constexpr TimePoint kNow{std::chrono::seconds{100}};
  for (std::size_t at = 0; at + words * 8 <= size; at += words * 8) {
    std::memcpy(report.data(), data + at, words * 8);
    static_cast<void>(writer.push(report));
    link.drain([&](record::Run run) {
      if (!check.accept(run, kNow)) return;
      if (run.number <= number || run.begin < end || run.end < run.begin) std::abort();
      for (const Nanos age : run.ages) {
        if (age < record::kNoAge || age > run.begin - TimePoint{}) std::abort();
      }
      number = run.number;
      end = run.end;
    });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const graph::App app = *config::parse_app(kApp, "app.yaml");
  open_anything(data, size, app.graph);
  read_reports(data, size, app);
  return 0;
}
