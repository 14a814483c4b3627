// What a page of a run needs in a browser: the folder script/ and style.css, put into the library by the build.
#pragma once

namespace ctn::page {

extern const char* const kScript;
extern const char* const kStyle;

}  // namespace ctn::page
