// The public client: the engine on Linux.
#include "catan/client.h"

#include <cmath>
#include <utility>

#include "api/in_one_process.h"
#include "os/linux/linux_os.h"
#include "runtime/client_engine.h"
#include "runtime/socket_path.h"

namespace ctn {
namespace {

runtime::NodePort& port_of(void* port) { return *static_cast<runtime::NodePort*>(port); }

}  // namespace

bool AttachedNode::wait() { return port_of(port_).wait_for_trigger(); }
Awaited AttachedNode::await() { return port_of(port_).await(); }
bool AttachedNode::await_complete() { return port_of(port_).await_complete(); }
void AttachedNode::begin(Run& run) { port_of(port_).begin(run); }
void AttachedNode::take(Run& run, std::string_view from, std::uint64_t first, std::uint64_t last) {
  port_of(port_).take(run, from, first, last);
}
void AttachedNode::end(Run& run) { port_of(port_).end(run); }

class Client::Impl : public api::InOneProcess<runtime::ClientEngine> {
 public:
  using InOneProcess::InOneProcess;
};

Result<Client> Client::connect(const ClientOptions& options) {
  std::vector<std::string> sockets{options.socket};
  if (options.socket.empty()) {
    Result<std::vector<std::string>> usual = runtime::sockets_to_try(options.app);
    if (!usual) return usual.error();
    sockets = std::move(*usual);
  }
  if (!std::isfinite(options.wait_seconds) || options.wait_seconds < 0.0 || options.wait_seconds > 1e6) {
    return Error::caller("wait_seconds is no time to wait", "write one from 0 to 1000000");
  }
  std::unique_ptr<os::Os> system = os::make_linux_os();
  Result<std::unique_ptr<runtime::ClientEngine>> engine =
      runtime::ClientEngine::connect(*system, {.sockets = std::move(sockets),
                                               .app = options.app,
                                               .wait = to_nanos(Millis{1000.0 * options.wait_seconds}),
                                               .on_notice = options.on_notice});
  if (!engine) return engine.error();
  return Client(std::make_unique<Impl>("client", std::move(system), std::move(*engine)));
}

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

void Client::node(std::string_view name, std::function<void(Run&)> body) {
  if (impl_->here()) impl_->engine().wiring().set_body(name, std::move(body));
}

ChannelBase& Client::open_channel(std::string_view from, std::string_view to, bool queue, std::type_index type,
                                  MakeChannel make) {
  runtime::Wiring& wiring = impl_->engine().wiring();
  return impl_->here() ? wiring.open_channel(from, to, queue, type, make) : wiring.unconnected_channel(make);
}

Status Client::start() {
  return impl_->ask([](runtime::ClientEngine& engine) { return engine.start(); });
}

Result<AttachedNode> Client::attach(std::string_view name) {
  const Result<runtime::NodePort*> port =
      impl_->ask([&](runtime::ClientEngine& engine) { return engine.attach(name); });
  if (!port) return port.error();
  return AttachedNode(*port);
}

Status Client::adopt_this_thread(std::string_view node) {
  return impl_->ask([&](runtime::ClientEngine& engine) { return engine.adopt_this_thread(node); });
}

Status Client::share_thread(int thread) {
  return impl_->ask([&](runtime::ClientEngine& engine) { return engine.share_thread(os::ThreadId{thread}); });
}

void Client::stop() {
  if (impl_->here()) impl_->engine().stop();
}

bool Client::served() const { return impl_->here() && impl_->engine().served(); }

}  // namespace ctn
