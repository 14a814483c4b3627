#include "catan/client.h"

#include <algorithm>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "capi/callbacks.h"
#include "capi/failure.h"
#include "capi/options.h"

struct catan_node {
  ctn::AttachedNode node;
  ctn::Run run;
};

struct catan_client {
  explicit catan_client(ctn::Client connected) : client(std::move(connected)) {}

  ctn::Client client;
  std::mutex mutex;             // guards what follows
  std::list<catan_node> nodes;  // that are attached
};

namespace {

ctn::Result<ctn::ClientOptions> options_of(const catan_client_options* given) {
  const ctn::Result<catan_client_options> known = ctn::capi::with_defaults(
      given, catan_client_options CATAN_CLIENT_OPTIONS, sizeof(catan_client_options), "CATAN_CLIENT_OPTIONS");
  if (!known) return known.error();
  const catan_client_options& options = *known;
  ctn::ClientOptions result;
  result.socket = ctn::capi::text_of(options.socket);
  result.app = ctn::capi::text_of(options.app);
  if (options.wait_seconds != 0.0) result.wait_seconds = std::max(options.wait_seconds, 0.0);
  result.on_notice = ctn::capi::notice_of(options.on_notice, options.on_notice_user);
  return result;
}

}  // namespace

catan_client* catan_client_connect(const catan_client_options* options, catan_error** error) {
  std::unique_ptr<catan_client> handle;
  ctn::capi::guarded(error, [&]() -> ctn::Status {
    const ctn::Result<ctn::ClientOptions> chosen = options_of(options);
    if (!chosen) return chosen.error();
    ctn::Result<ctn::Client> client = ctn::Client::connect(*chosen);
    if (!client) return client.error();
    handle = std::make_unique<catan_client>(std::move(*client));
    return ctn::Done{};
  });
  return handle.release();
}

void catan_client_node(catan_client* client, const char* name, catan_node_function function, void* user) {
  if (client == nullptr) return;
  ctn::capi::guarded(nullptr, [&]() -> ctn::Status {
    client->client.node(ctn::capi::text_of(name), ctn::capi::body_of(function, user));
    return ctn::Done{};
  });
}

catan_status catan_client_start(catan_client* client, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    return client == nullptr ? ctn::Status(ctn::capi::missing("client")) : client->client.start();
  });
}

catan_status catan_client_adopt_this_thread(catan_client* client, const char* node, catan_error** error) {
  return ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (client == nullptr) return ctn::capi::missing("client");
    return client->client.adopt_this_thread(ctn::capi::text_of(node));
  });
}

int catan_client_served(const catan_client* client) { return client != nullptr && client->client.served() ? 1 : 0; }

void catan_client_stop(catan_client* client) {
  if (client == nullptr) return;
  ctn::capi::guarded(nullptr, [&]() -> ctn::Status {
    client->client.stop();
    return ctn::Done{};
  });
}

void catan_client_free(catan_client* client) { delete client; }

catan_node* catan_client_attach(catan_client* client, const char* name, catan_error** error) {
  catan_node* attached = nullptr;
  ctn::capi::guarded(error, [&]() -> ctn::Status {
    if (client == nullptr) return ctn::capi::missing("client");
    const ctn::Result<ctn::AttachedNode> node = client->client.attach(ctn::capi::text_of(name));
    if (!node) return node.error();
    const std::lock_guard lock(client->mutex);
    attached = &client->nodes.emplace_back(catan_node{*node, {}});
    return ctn::Done{};
  });
  return attached;
}

// On the hot path, so that nothing is checked here.
int catan_node_wait(catan_node* node) { return node->node.wait() ? 1 : 0; }
catan_run* catan_node_begin(catan_node* node) {
  node->node.begin(node->run);
  return ctn::capi::handle_of(node->run);
}
void catan_node_end(catan_node* node) { node->node.end(node->run); }

uint64_t catan_run_number(const catan_run* run) { return ctn::capi::run_of(run).number(); }
int catan_run_threads(const catan_run* run) { return ctn::capi::run_of(run).threads(); }
void catan_run_set_mode(catan_run* run, uint32_t mode) { ctn::capi::run_of(run).set_mode(mode); }
int64_t catan_run_age_ns(catan_run* run, const char* input) {
  return ctn::capi::run_of(run).age(ctn::capi::text_of(input)).count();
}
int catan_run_stale(catan_run* run) { return ctn::capi::run_of(run).stale() ? 1 : 0; }
void catan_run_skip_output(catan_run* run) { ctn::capi::run_of(run).skip_output(); }
