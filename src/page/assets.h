// What the page of a run needs in a browser: the folder script/ and style.css, which the build puts into the library.
#pragma once

namespace ctn::page {

extern const char* const kScript;
extern const char* const kStyle;

}  // namespace ctn::page
