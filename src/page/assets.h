// What the page of a run needs in a browser: the folder script/ and style.css, which the build puts into the library.
#pragma once

#include <span>

namespace ctn::page {

extern const char* const kScript;
extern const char* const kStyle;

// The colours of src/palette.js, "#3d8fd1".
std::span<const char* const> palette();

}  // namespace ctn::page
