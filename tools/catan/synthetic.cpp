#include "synthetic.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace ctn::tool {
namespace {

// What travels along an edge: the number of the run that made it.
using Token = std::uint64_t;

// Long enough for most runs to end by themselves, short enough for whoever pressed Ctrl-C.
constexpr Nanos kGrace = std::chrono::seconds{1};

// The load is computing and not system calls: some microseconds of work between two looks at the clock, and less where
// little is left, so as to end on time.
constexpr Nanos kNearTheEnd = std::chrono::microseconds{200};
constexpr int kManySteps = 10'000;
constexpr int kFewSteps = 500;

void compute(int steps) {
  volatile std::uint64_t result = 1;
  std::uint64_t x = result;
  for (int i = 0; i < steps; ++i) x = x * 6364136223846793005U + 1442695040888963407U;
  result = x;
}

}  // namespace

bool OutputClock::due(TimePoint now) {
  if (!period_) return true;
  if (next_ && now < *next_) return false;
  next_ = std::max(next_.value_or(now) + *period_, now);
  return true;
}

struct SyntheticLoad::Node {
  NodeId id;
  OutputClock output;
  std::vector<Channel<Token>*> latest;  // its inputs, of which a node has one kind
  std::vector<QueueChannel<Token>*> queued;
  std::vector<Channel<Token>*> to_latest;  // its outputs
  std::vector<QueueChannel<Token>*> to_queue;
};

SyntheticLoad::SyntheticLoad(const graph::App& app, model::Workload work, std::uint64_t seed, os::Os& os)
    : app_(app), work_(std::move(work)), seed_(seed), os_(os) {
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    nodes_.push_back(
        std::make_unique<Node>(Node{NodeId(i), OutputClock(app.graph.nodes()[i].output_period), {}, {}, {}, {}}));
  }
}

SyntheticLoad::~SyntheticLoad() = default;

void SyntheticLoad::attach(Session& session) {
  for (const graph::Edge& edge : app_.graph.edges()) {
    const graph::Node& from = app_.graph.node(edge.from);
    const graph::Node& to = app_.graph.node(edge.to);
    if (from.external || to.external) continue;
    if (to.input == graph::InputKind::kQueue) {
      auto& queue = session.queue<Token>(from.name, to.name);
      nodes_[edge.from.index()]->to_queue.push_back(&queue);
      nodes_[edge.to.index()]->queued.push_back(&queue);
    } else {
      auto& channel = session.channel<Token>(from.name, to.name);
      nodes_[edge.from.index()]->to_latest.push_back(&channel);
      nodes_[edge.to.index()]->latest.push_back(&channel);
    }
  }
  for (const auto& node : nodes_) {
    const graph::Node& described = app_.graph.node(node->id);
    if (!described.external) session.node(described.name, [this, &node = *node](Run& run) { this->run(node, run); });
  }
}

void SyntheticLoad::begin() { begun_ = os_.now(); }

void SyntheticLoad::run(Node& node, Run& run) {
  const Nanos cpu_before = os_.thread_cpu_time();
  for (Channel<Token>* channel : node.latest) static_cast<void>(channel->read(run));
  for (QueueChannel<Token>* queue : node.queued) {
    while (queue->take(run)) {
    }
  }
  const model::RunDraw draw = work_.draw(seed_, node.id, run.number(), os_.now() - begun_);
  run.set_mode(static_cast<std::uint32_t>(draw.mode));
  if (!burn(cpu_before + draw.cpu) || !node.output.due(os_.now())) return run.skip_output();
  for (Channel<Token>* channel : node.to_latest) channel->write(run, run.number());
  for (QueueChannel<Token>* queue : node.to_queue) queue->write(run, run.number());
}

bool SyntheticLoad::burn(Nanos until_cpu_time) const {
  while (!cut_short()) {
    const Nanos left = until_cpu_time - os_.thread_cpu_time();
    if (left <= Nanos{0}) return true;
    compute(left > kNearTheEnd ? kManySteps : kFewSteps);
  }
  return false;
}

void SyntheticLoad::stop() { stop_by_.store(os_.now() + kGrace, std::memory_order_relaxed); }

bool SyntheticLoad::cut_short() const {
  const TimePoint stop_by = stop_by_.load(std::memory_order_relaxed);
  return stop_by != kNever && os_.now() >= stop_by;
}

}  // namespace ctn::tool
