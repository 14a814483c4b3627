// Runs a session of one node for a moment, with nothing but what is installed.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "catan/session.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  auto session = ctn::Session::open(argv[1], {});
  if (!session) {
    std::fprintf(stderr, "%s\n", session.error().message().c_str());
    return 1;
  }
  std::atomic<int> runs{0};
  session->node("tick", [&](ctn::Run&) { ++runs; });
  if (!session->start()) return 1;
  std::this_thread::sleep_for(std::chrono::milliseconds{200});
  if (!session->stop()) return 1;
  std::printf("%d runs\n", runs.load());
  return runs > 0 ? 0 : 1;
}
