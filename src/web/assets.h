// The live page as browsers get it: the folder page/, which the build puts into the library.
#pragma once

namespace ctn::web {

extern const char* const kPage;
extern const char* const kPageStyle;
extern const char* const kPageScript;

}  // namespace ctn::web
