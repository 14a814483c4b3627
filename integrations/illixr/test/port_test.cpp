// The port to ILLIXR passes the suite: each program of it is ILLIXR's runtime, which loads the plugin `catan` and one
// plugin for each node. These are sources of plugins like any other's: what they know of Catan is the first line.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/binding.h"
#include "conformance/helper.h"
#include "conformance/suite.h"
#include "illixr/plugin_hooks.h"
#include "illixr/runtime.hpp"
#include "illixr/threadloop.hpp"

namespace ctn::conformance {
namespace {

using namespace ILLIXR;

struct number : public switchboard::event {
  explicit number(std::int64_t given) : value{given} {}
  std::int64_t value;
};

std::string topic_of(const std::string& node) { return "conformance_" + node; }

class IllixrCall final : public Call {
 public:
  using Take = std::function<std::vector<std::int64_t>(const std::string& from)>;
  IllixrCall(Take take, switchboard::writer<number>& out, Helper& helper)
      : take_(std::move(take)), out_(out), helper_(helper) {}
  std::vector<std::int64_t> take(const std::string& from) override { return take_(from); }
  void publish(std::int64_t message) override { out_.put(out_.allocate(message)); }
  void on_another_thread(const std::function<void()>& work) override { helper_.help(work); }

 private:
  const Take take_;
  switchboard::writer<number>& out_;
  Helper& helper_;
};

// A node that takes the newest message of one other: a callback of the switchboard.
class CallbackPlugin final : public plugin {
 public:
  CallbackPlugin(phonebook* book, const Node& node)
      : plugin{node.name, book},
        node_(node),
        switchboard_{book->lookup_impl<switchboard>()},
        out_{switchboard_->get_writer<number>(topic_of(node.name))} {
    switchboard_->schedule<number>(
        id_, topic_of(node.inputs[0].from), [this](switchboard::ptr<const number>&& event, std::size_t) {
          IllixrCall call([&](const std::string&) { return std::vector{event->value}; }, out_, helper_);
          node_.callback(call);
        });
  }

 private:
  const Node node_;
  const std::shared_ptr<switchboard> switchboard_;
  switchboard::writer<number> out_;
  Helper helper_;
};

// Any other: a threadloop, which keeps its own time or is ready at any time, and reads what it takes.
class LoopPlugin final : public threadloop {
 public:
  LoopPlugin(phonebook* book, const Node& node)
      : threadloop{node.name, book},
        node_(node),
        switchboard_{book->lookup_impl<switchboard>()},
        out_{switchboard_->get_writer<number>(topic_of(node.name))} {
    for (const Node::Input& input : node.inputs) {
      if (input.queue) {
        queues_.push_back({input.from, switchboard_->get_buffered_reader<number>(topic_of(input.from))});
      } else {
        newest_.push_back({input.from, switchboard_->get_reader<number>(topic_of(input.from)), nullptr});
      }
    }
  }

 protected:
  skip_option _p_should_skip() override {
    if (node_.timer) std::this_thread::sleep_for(*node_.timer);
    return skip_option::run;
  }
  void _p_one_iteration() override {
    IllixrCall call([this](const std::string& from) { return take(from); }, out_, helper_);
    node_.callback(call);
  }

 private:
  struct Queue {
    std::string from;
    switchboard::buffered_reader<number> reader;
  };
  struct Newest {
    std::string from;
    switchboard::reader<number> reader;
    switchboard::ptr<const number> before;
  };

  std::vector<std::int64_t> take(const std::string& from) {
    std::vector<std::int64_t> taken;
    for (Queue& queue : queues_) {
      while (queue.from == from && queue.reader.size() > 0) taken.push_back(queue.reader.dequeue()->value);
    }
    for (Newest& newest : newest_) {
      const auto event = newest.from == from ? newest.reader.get_ro_nullable() : nullptr;
      if (event && event != newest.before) taken.push_back(event->value);
      if (event) newest.before = event;
    }
    return taken;
  }

  const Node node_;
  const std::shared_ptr<switchboard> switchboard_;
  switchboard::writer<number> out_;
  std::vector<Queue> queues_;
  std::vector<Newest> newest_;
  Helper helper_;
};

bool is_callback(const Node& node) { return node.inputs.size() == 1 && !node.inputs[0].queue && !node.timer; }

catan_ros::Binding binding_of(const Node& node) {
  catan_ros::Binding binding;
  binding.node = node.name;
  binding.ros_node = node.name;
  binding.kind = is_callback(node) ? catan_ros::Binding::Kind::kTopic : catan_ros::Binding::Kind::kLoop;
  if (is_callback(node)) binding.name = topic_of(node.inputs[0].from);
  binding.runs_by_itself = node.timer.has_value();
  binding.always_gives_output = !node.publishes;
  for (const Node::Input& input : node.inputs) binding.predecessors.push_back(input.from);
  return binding;
}

// The runtime makes plugins by functions without arguments of ours.
const Node* g_next = nullptr;
plugin* make_plugin(phonebook* book) {
  if (is_callback(*g_next)) return new CallbackPlugin(book, *g_next);
  return new LoopPlugin(book, *g_next);
}

class IllixrPort final : public Port {
 public:
  int run(const std::vector<Node>& nodes, const std::atomic<bool>& stop) override {
    std::vector<catan_ros::Binding> bindings;
    std::transform(nodes.begin(), nodes.end(), std::back_inserter(bindings), binding_of);
    ::setenv(catan_ros::kIllixrBindingsVariable, catan_ros::to_text(bindings).c_str(), 1);
    ::setenv("ILLIXR_DISPLAY_MODE", "none", 1);
    const std::unique_ptr<runtime> illixr(runtime_factory());
    illixr->load_so(std::vector<std::string>{CATAN_PLUGIN});
    for (const Node& node : nodes) {
      g_next = &node;
      illixr->load_plugin_factory(make_plugin);
    }
    while (!stop.load()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
    illixr->stop();
    illixr->wait();
    return 0;
  }
};

std::unique_ptr<Port> make_port() { return std::make_unique<IllixrPort>(); }

INSTANTIATE_TEST_SUITE_P(Illixr, PortSuite, testing::Values(PortUnderTest{"illixr", make_port}), name_of);

}  // namespace
}  // namespace ctn::conformance
