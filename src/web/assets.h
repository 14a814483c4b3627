// The page that a browser is given: the folder page/, put into the library by the build.
#pragma once

namespace ctn::web {

extern const char* const kPage;
extern const char* const kPageStyle;
extern const char* const kPageScript;

}  // namespace ctn::web
