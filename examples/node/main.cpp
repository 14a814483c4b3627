// One node of an app, in a process of its own: node NAME.
#include <catan/client.h>

#include <cstdio>

#include "work.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  auto client = ctn::Client::connect();
  if (!client) return std::fprintf(stderr, "node: %s\n", client.error().message().c_str()), 1;
  client->node(argv[1], [](ctn::Run&) { work(); });  // what the node does, once each time it is triggered
  if (auto started = client->start(); !started) {
    return std::fprintf(stderr, "node: %s\n", started.error().message().c_str()), 1;
  }
  wait_for_the_end();
  client->stop();
}
