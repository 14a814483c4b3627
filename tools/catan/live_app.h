// An app that runs on this machine, as its recording shows it: what `catan top`, `catan http` and `catan ros node`
// watch.
//
// Thread safety: one thread.
#pragma once

#include <utility>

#include "flight/recording.h"
#include "os/os.h"
#include "record/sink.h"
#include "view/live_view.h"

namespace ctn::tool {

class LiveApp {
 public:
  explicit LiveApp(flight::Recording recording)
      : recording_(std::move(recording)), view_(recording_.app(), recording_.header()) {}

  // Takes what has happened since it was last called, and looks whether the app is still there. `also` gets the same
  // events; none: nobody does.
  void refresh(os::Os& os, record::Sink* also = nullptr);
  // Of now, with the events up to the last refresh().
  view::Picture picture(os::Os& os) const { return view_.picture(os.now(), life_); }

  // Whether the app had ended, in order or not, at the last refresh().
  bool has_ended() const { return life_.over || life_.gone; }
  const flight::Recording& recording() const { return recording_; }
  view::LiveView& view() { return view_; }

 private:
  flight::Recording recording_;
  view::LiveView view_;
  view::Life life_;
};

}  // namespace ctn::tool
