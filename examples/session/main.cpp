// An app in one process: session APP [RECORD] runs it for two seconds.
#include <catan/session.h>

#include <chrono>
#include <cstdio>
#include <thread>

int fail(const ctn::Error& error) { return std::fprintf(stderr, "session: %s\n", error.message().c_str()), 1; }

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  ctn::SessionOptions options;
  if (argc > 2) options.record = argv[2];
  auto session = ctn::Session::open(argv[1], options);
  if (!session) return fail(session.error());
  auto& distances = session->channel<double>("scan", "drive");
  session->node("scan", [&](ctn::Run& run) { distances.write(run, 1.0 + static_cast<double>(run.number() % 10)); });
  session->node("drive", [&](ctn::Run& run) {
    if (const double* distance = distances.read(run); distance == nullptr || *distance < 2.0) run.skip_output();
  });
  if (auto started = session->start(); !started) return fail(started.error());
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const ctn::Snapshot measured = session->snapshot();
  if (auto stopped = session->stop(); !stopped) return fail(stopped.error());
  for (const ctn::NodeSnapshot& node : measured.nodes) std::printf("%s: %.1f Hz\n", node.name.c_str(), node.rate_hz);
}
