// What an attached node (client.h) that can also do without triggers has waited for.
#pragma once

#include <cstdint>

namespace ctn {

enum class Awaited : std::uint8_t {
  kTrigger,     // the node is to run
  kIncomplete,  // the server has let go of its subchain, of which a node is missing: nothing is triggered until it
                // comes
  kStopped,     // the client was stopped
};

}  // namespace ctn
