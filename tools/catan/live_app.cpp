#include "live_app.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

namespace ctn::tool {

void LiveApp::refresh(os::Os& os, record::Sink* also) {
  std::vector<record::Sink*> sinks{&view_};
  if (also != nullptr) sinks.push_back(also);
  record::ForwardingSink all(sinks);
  if (recording_.read_new(all) > 0) view_.lost();
  life_ = {recording_.seen_alive(), recording_.over(), false};
  if (os.now() - life_.seen_alive > view::kStalledAfter) {
    std::error_code unknown;
    life_.gone = !std::filesystem::exists(fmt::format("/proc/{}", recording_.process()), unknown);
  }
  if (has_ended()) view_.ended();
}

}  // namespace ctn::tool
