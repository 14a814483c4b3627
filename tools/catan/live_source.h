// What `catan http` and `catan ros node` show: an app that runs on this machine, through its recording (attach.h).
// Where no such app runs at present, calls say so, and later ones look again: a server may start later, end and come
// back.
//
// Events are read only while clients ask. Thread safety: all functions from any thread; they lock.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "flight/recording.h"
#include "live_app.h"
#include "os/os.h"
#include "web/source.h"
#include "web/timeline.h"

namespace ctn::tool {

class LiveSource final : public web::Source {
 public:
  // `target`: as attach() has it.
  LiveSource(os::Os& os, std::string target) : os_(os), target_(std::move(target)) {}

  // Whether there is an app to show now. Errors: as attach() has them.
  Status look();
  // The CPUs that the app was started with; nothing: there is no app at present.
  std::optional<os::CpuSet> cpus();

  Result<std::string> live() override;
  Result<std::string> timeline() override;
  Result<std::string> snapshot() override;
  Result<std::string> plan() override;
  Status change(const Changes& changes) override;
  // Reads the whole recording once more, and plans in a thread of its own, which yields to all others, so that the page
  // goes on.
  Result<std::string> what_if(const web::WhatIf& asked) override;

 private:
  // An app that was found.
  struct Watched {
    explicit Watched(flight::Recording found)
        : app(std::move(found)), timeline(app.recording().app(), app.recording().header().started) {}

    LiveApp app;
    web::Timeline timeline;
  };

  // The app, with all events up to now. Precondition: mutex_ is locked.
  Result<Watched*> watched();
  // Precondition: mutex_ is locked.
  void look_for_app(TimePoint now);
  Result<runtime::ServerAddress> server();

  os::Os& os_;
  const std::string target_;
  std::mutex mutex_;
  std::unique_ptr<Watched> watched_;
  TimePoint read_at_{};
  std::optional<TimePoint> looked_at_;
  std::optional<Error> missing_;  // why the app was not found when it was looked for last
};

}  // namespace ctn::tool
