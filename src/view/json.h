// A picture as JSON: `catan top --once --json`. docs/top.md lists the keys.
#pragma once

#include <string>

#include "view/picture.h"

namespace ctn::view {

std::string to_json(const Picture& picture);

}  // namespace ctn::view
