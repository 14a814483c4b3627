#include "catan_hook.h"

#include <chrono>
#include <thread>

namespace relay_catan {
namespace {

// While there is no server.
constexpr std::chrono::milliseconds kTryAgain{100};

// A component as a node.
class NodePacing final : public relay::Pacing {
 public:
  NodePacing(const relay::Component& component, ctn::AttachedNode node)
      : triggered_(!component.timer), ends_a_chain_(component.publishes.empty()), node_(node) {}

  bool paces() const override { return triggered_; }
  bool wait() override { return node_.wait(); }
  void begin() override { node_.begin(run_); }
  void end(bool published) override {
    // A component that has no topic to publish on gives its output to the world.
    if (!published && !ends_a_chain_) run_.skip_output();
    node_.end(run_);
  }

 private:
  bool triggered_;
  bool ends_a_chain_;
  ctn::AttachedNode node_;
  ctn::Run run_;
};

}  // namespace

void CatanHook::stop() {
  const std::lock_guard lock(client_mutex_);
  stopped_ = true;
  client_.stop();
}

std::string CatanHook::error() const {
  const std::lock_guard lock(error_mutex_);
  return error_;
}

void CatanHook::complain(const relay::Component& component, const ctn::Error& error) {
  const std::lock_guard lock(error_mutex_);
  if (error_.empty()) error_ = component.name + ": " + error.message();
}

// A component that is no node, or a node that another program runs, is a mistake; that there is no server at this
// moment is none.
std::unique_ptr<relay::Pacing> CatanHook::thread_begins(const relay::Component& component) {
  for (;; std::this_thread::sleep_for(kTryAgain)) {
    const std::lock_guard lock(client_mutex_);
    if (stopped_) return nullptr;
    const ctn::Result<ctn::AttachedNode> attached = client_.attach(component.name);
    if (attached) return std::make_unique<NodePacing>(component, *attached);
    if (attached.error().kind() == ctn::ErrorKind::kCaller) {
      complain(component, attached.error());
      return nullptr;
    }
  }
}

// Where it is refused the thread stays at the ordinary level: worth telling, not worth ending.
void CatanHook::thread_helps(const relay::Component& component) {
  const std::lock_guard lock(client_mutex_);
  if (stopped_) return;
  const ctn::Status adopted = client_.adopt_this_thread(component.name);
  if (!adopted) complain(component, adopted.error());
}

}  // namespace relay_catan
