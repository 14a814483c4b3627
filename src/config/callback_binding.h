// A node of an app and the callback of a framework that it is.
//
// Thread safety: plain values.
#pragma once

#include "base/ids.h"

namespace ctn::config {

template <class Callback>
struct CallbackBinding {
  NodeId node;
  Callback callback;
};

}  // namespace ctn::config
