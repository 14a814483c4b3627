// Command lines for a shell.
#pragma once

#include <string>

namespace ctn::experiments {

// As one word, whatever is in it.
std::string quoted(const std::string& text);

}  // namespace ctn::experiments
