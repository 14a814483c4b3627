#include "synthetic.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/run_access.h"
#include "workers.h"

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

// A session takes no more for a node.
constexpr int kMaxThreads = 64;

void compute(int steps) {
  volatile std::uint64_t result = 1;
  std::uint64_t x = result;
  for (int i = 0; i < steps; ++i) x = x * 6364136223846793005U + 1442695040888963407U;
  result = x;
}

// What others' nodes gave it arrives without content: so many runs of theirs it has consumed when it begins.
std::size_t consumed_before_reading(const Run& run) {
  std::size_t runs = 0;
  for (const RunAccess::Input& input : RunAccess::inputs(run)) {
    if (input.first != 0) runs += static_cast<std::size_t>(input.last - input.first + 1);
  }
  return runs;
}

}  // namespace

bool OutputClock::due(TimePoint now) {
  if (!period_) return true;
  if (next_ && now < *next_) return false;
  next_ = std::max(next_.value_or(now) + *period_, now);
  return true;
}

struct SyntheticLoad::Node {
  Node(NodeId node, OutputClock clock) : id(node), output(clock) {}

  NodeId id;
  OutputClock output;
  bool here = false;                    // in this process
  std::vector<Channel<Token>*> latest;  // its inputs, of which a node has one kind
  std::vector<QueueChannel<Token>*> queued;
  std::vector<Channel<Token>*> to_latest;  // its outputs
  std::vector<QueueChannel<Token>*> to_queue;
  std::unique_ptr<Workers> workers;
  std::atomic<Workers*> at_work{nullptr};  // the same, once they are there
};

SyntheticLoad::SyntheticLoad(const graph::App& app, model::Workload work, std::uint64_t seed, os::Os& os)
    : app_(app), work_(std::move(work)), seed_(seed), os_(os) {
  for (std::size_t i = 0; i < app.graph.nodes().size(); ++i) {
    nodes_.push_back(std::make_unique<Node>(NodeId(i), OutputClock(app.graph.nodes()[i].output_period)));
  }
}

SyntheticLoad::~SyntheticLoad() = default;

template <class Host>
void SyntheticLoad::attach_to(Host& host, const std::vector<NodeId>& nodes) {
  const auto is_here = [&](NodeId node) { return std::find(nodes.begin(), nodes.end(), node) != nodes.end(); };
  for (const graph::Edge& edge : app_.graph.edges()) {
    if (!is_here(edge.from) || !is_here(edge.to)) continue;
    const graph::Node& from = app_.graph.node(edge.from);
    const graph::Node& to = app_.graph.node(edge.to);
    if (to.input == graph::InputKind::kQueue) {
      auto& queue = host.template queue<Token>(from.name, to.name);
      nodes_[edge.from.index()]->to_queue.push_back(&queue);
      nodes_[edge.to.index()]->queued.push_back(&queue);
    } else {
      auto& channel = host.template channel<Token>(from.name, to.name);
      nodes_[edge.from.index()]->to_latest.push_back(&channel);
      nodes_[edge.to.index()]->latest.push_back(&channel);
    }
  }
  for (const NodeId id : nodes) {
    nodes_[id.index()]->here = true;
    host.node(app_.graph.node(id).name, [this, &node = *nodes_[id.index()]](Run& run) { this->run(node, run); });
  }
}

std::vector<NodeId> SyntheticLoad::all_nodes() const {
  std::vector<NodeId> nodes;
  for (std::size_t index = 0; index < nodes_.size(); ++index) {
    if (!app_.graph.nodes()[index].external) nodes.emplace_back(index);
  }
  return nodes;
}

void SyntheticLoad::attach(Session& session) { attach_to(session, all_nodes()); }
void SyntheticLoad::attach(Client& client) { attach_to(client, all_nodes()); }
void SyntheticLoad::attach(Client& client, const std::vector<NodeId>& nodes) { attach_to(client, nodes); }

void SyntheticLoad::begin() { begun_ = os_.now(); }

template <class Host>
Status SyntheticLoad::add_threads(Host& host) {
  const Result<os::CpuSet> cpus = os_.online_cpus();
  if (!cpus) return cpus.error();
  for (const auto& node : nodes_) {
    const graph::Node& described = app_.graph.node(node->id);
    if (!node->here) continue;
    const int threads = std::min({described.max_threads, static_cast<int>(cpus->size()), kMaxThreads});
    if (threads < 2) continue;
    node->workers = std::make_unique<Workers>(
        os_, threads - 1, [&] { return host.adopt_this_thread(described.name); },
        [this](Nanos cpu) { burn(os_.thread_cpu_time() + cpu); });
    if (Status joined = node->workers->joined(); !joined) return joined;
    node->at_work.store(node->workers.get(), std::memory_order_release);
  }
  return Done{};
}

template Status SyntheticLoad::add_threads(Session& host);
template Status SyntheticLoad::add_threads(Client& host);

void SyntheticLoad::run(Node& node, Run& run) {
  const Nanos cpu_before = os_.thread_cpu_time();
  for (Channel<Token>* channel : node.latest) static_cast<void>(channel->read(run));
  const bool takes_batches = app_.graph.node(node.id).input == graph::InputKind::kQueue;
  std::size_t items = takes_batches ? consumed_before_reading(run) : 0;
  for (QueueChannel<Token>* queue : node.queued) {
    while (queue->take(run)) ++items;
  }
  Workers* const workers = node.at_work.load(std::memory_order_acquire);
  const int max = workers != nullptr ? std::min(run.threads(), workers->count() + 1) : 1;
  const int threads = work_[node.id].cost.threads_used(max);
  const model::RunDraw draw = work_.draw(seed_, node.id, run.number(), os_.now() - begun_, threads);
  run.set_mode(static_cast<std::uint32_t>(draw.mode));
  const Nanos cpu = draw.cpu_with(items);
  if (threads > 1) workers->begin(threads - 1, cpu);
  const Nanos after_wait = draw.wait > Nanos{0} ? cpu / 2 : Nanos{0};
  bool burnt = burn(cpu_before + cpu - after_wait);
  if (draw.wait > Nanos{0}) burnt = burnt && sleep(draw.wait) && burn(cpu_before + cpu);
  if (threads > 1) workers->finish();
  if (!burnt || !node.output.due(os_.now())) return run.skip_output();
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

bool SyntheticLoad::sleep(Nanos wait) {
  const TimePoint end = os_.now() + wait;
  if (os_.wait(stopping_, 0, end) == os::WaitResult::kTimedOut) return true;
  os_.wait(stopping_, 1, std::min(end, stop_by_.load(std::memory_order_relaxed)));
  return os_.now() >= end;
}

void SyntheticLoad::stop() {
  stop_by_.store(os_.now() + kGrace, std::memory_order_relaxed);
  stopping_.store(1, std::memory_order_release);
  os_.wake(stopping_);
}

bool SyntheticLoad::cut_short() const {
  const TimePoint stop_by = stop_by_.load(std::memory_order_relaxed);
  return stop_by != kNever && os_.now() >= stop_by;
}

}  // namespace ctn::tool
