// What `catan http` shows: an app that runs on this machine, as it can be seen from outside (attach.h). Where there is
// none at present, it says so, and looks again: a server may start later, end and come back.
//
// What has happened is read only while it is asked for. Thread safety: all calls from any thread; each locks.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "flight/recording.h"
#include "os/os.h"
#include "view/live_view.h"
#include "web/source.h"
#include "web/timeline.h"

namespace ctn::tool {

class HttpSource final : public web::Source {
 public:
  // `target`: as attach() has it.
  HttpSource(os::Os& os, std::string target) : os_(os), target_(std::move(target)) {}

  // Whether there is one to show now. Errors: as attach() has them.
  Status look();
  // CPUs that its nodes may use; nothing: there is none at present.
  std::optional<os::CpuSet> cpus();

  Result<std::string> live() override;
  Result<std::string> timeline() override;
  Result<std::string> snapshot() override;
  Result<std::string> plan() override;
  Status change(const Changes& changes) override;
  // Reads all that is kept once more, and plans in a thread of its own, after all others: what is shown goes on.
  Result<std::string> what_if(const web::WhatIf& asked) override;

 private:
  // One app, from when it was found.
  struct Watched {
    explicit Watched(flight::Recording found)
        : recording(std::move(found)),
          view(recording.app(), recording.header()),
          timeline(recording.app(), recording.header().started) {}

    flight::Recording recording;
    view::LiveView view;
    web::Timeline timeline;
    view::Life life;
  };

  // Up to date. Precondition: locked.
  Result<Watched*> watched();
  Result<std::vector<std::string>> sockets();

  os::Os& os_;
  const std::string target_;
  std::mutex mutex_;
  std::unique_ptr<Watched> watched_;
  TimePoint read_at_{};
  std::optional<Error> missing_;
};

}  // namespace ctn::tool
