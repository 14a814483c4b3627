// What an error of the kernel means, in words.
//
// Thread safety: a pure function.
#pragma once

#include <string>
#include <system_error>

namespace ctn::os {

inline std::string errno_text(int error) { return std::generic_category().message(error); }

}  // namespace ctn::os
