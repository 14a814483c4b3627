// An app of one node in memory that two processes share, and some words through which they agree what to do next. To be
// made before the other process is.
//
// Thread safety: as that of a region.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

#include "base/result.h"
#include "config/app_file.h"
#include "os/linux/shared_memory.h"
#include "runtime/region.h"

namespace ctn::tool {

struct Agreement {
  alignas(64) std::atomic<std::uint32_t> go{0};
  alignas(64) std::atomic<std::uint32_t> done{0};
  alignas(64) std::atomic<std::int64_t> first{0};  // ns of the monotonic clock: when the other came to act
  std::atomic<std::int64_t> cost{0};               // ns
  std::atomic<std::int64_t> bare_cost{0};          // ns
};

class SharedApp {
 public:
  static Result<std::unique_ptr<SharedApp>> make() {
    Result<graph::App> app = config::parse_app(kText, "bench");
    if (!app) return app.error();
    Result<os::SharedMemory> beside = os::SharedMemory::create("catan-bench", sizeof(Agreement));
    if (!beside) return beside.error();
    Result<os::SharedMemory> memory =
        os::SharedMemory::create("catan-bench", runtime::Region::size_for(app->graph, 1, kText));
    if (!memory) return memory.error();
    return std::unique_ptr<SharedApp>(new SharedApp(std::move(*app), std::move(*memory), std::move(*beside)));
  }

  const graph::Graph& graph() const { return app_.graph; }
  NodeId node() const { return NodeId(std::size_t{0}); }
  const runtime::Region& region() const { return region_; }
  Agreement& agreement() const { return *agreement_; }

 private:
  static constexpr const char* kText =
      "catan: 1\napp: bench\nnodes: { node: {} }\nedges: []\nobjective: [ { period: node, weight: 1 } ]\n";

  SharedApp(graph::App app, os::SharedMemory memory, os::SharedMemory beside)
      : app_(std::move(app)),
        memory_(std::move(memory)),
        beside_(std::move(beside)),
        region_(runtime::Region::create(app_.graph, 1, kText, memory_.bytes())),
        agreement_(new (beside_.bytes().data()) Agreement) {}

  graph::App app_;
  os::SharedMemory memory_;
  os::SharedMemory beside_;
  runtime::Region region_;
  Agreement* agreement_;
};

}  // namespace ctn::tool
