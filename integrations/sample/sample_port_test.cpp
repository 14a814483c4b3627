// The sample port passes the suite.
#include <chrono>
#include <cstdio>
#include <thread>

#include "catan_hook.h"
#include "conformance/suite.h"

namespace ctn::conformance {
namespace {

class RelayCall final : public Call {
 public:
  explicit RelayCall(relay::Call& call) : call_(call) {}
  std::vector<std::int64_t> take(const std::string& from) override { return call_.take(from); }
  void publish(std::int64_t message) override { call_.publish(message); }
  void on_another_thread(const std::function<void()>& work) override { call_.help(work); }

 private:
  relay::Call& call_;
};

relay::Component component_of(const Node& node) {
  relay::Component component;
  component.name = node.name;
  for (const Node::Input& input : node.inputs) {
    component.subscriptions.push_back({input.from, input.queue ? relay::Keep::kAll : relay::Keep::kNewest});
  }
  component.publishes = node.publishes ? node.name : "";
  component.timer = node.timer;
  component.has_helper = node.has_another_thread;
  component.callback = [callback = node.callback](relay::Call& call) {
    RelayCall wrapped(call);
    callback(wrapped);
  };
  return component;
}

class SamplePort final : public Port {
 public:
  int run(const std::vector<Node>& nodes, const std::atomic<bool>& stop) override {
    Result<Client> client = Client::connect();
    if (!client) return fail(client.error().message());
    if (const Status started = client->start(); !started) return fail(started.error().message());
    relay_catan::CatanHook hook(*client);
    relay::Executor executor(&hook);
    for (const Node& node : nodes) executor.add(component_of(node));
    std::thread stopper([&] {
      while (!stop.load()) std::this_thread::sleep_for(std::chrono::milliseconds{2});
      executor.stop();
      hook.stop();
    });
    executor.spin();
    stopper.join();
    return hook.error().empty() ? 0 : fail(hook.error());
  }

 private:
  static int fail(const std::string& why) {
    std::fprintf(stderr, "sample port: %s\n", why.c_str());
    return 1;
  }
};

std::unique_ptr<Port> make_port() { return std::make_unique<SamplePort>(); }

INSTANTIATE_TEST_SUITE_P(Sample, PortSuite, testing::Values(PortUnderTest{"sample", make_port}), name_of);

}  // namespace
}  // namespace ctn::conformance
