// What must hold of a text before the YAML library may see it: size, encoding, characters.
#pragma once

#include <optional>
#include <string_view>

#include "base/result.h"

namespace ctn::config {

// The first thing wrong with it. `file` names the text.
std::optional<Problem> check_text(std::string_view text, std::string_view file);

}  // namespace ctn::config
