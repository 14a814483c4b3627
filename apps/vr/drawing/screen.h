// Which of two screens something is drawn on.
//
// Mesa's software renderer (llvmpipe), which takes the place of a GPU that is not there, has one lock for all contexts
// of a display, held for as long as it fills a picture: a thread of high priority would wait for a low one's picture.
// So there are two screens, which are displays of their own, and what must not wait is opened on another screen than
// what it may interrupt.
#pragma once

namespace ctn::vr::drawing {

enum class Screen { kFirst, kSecond };

}  // namespace ctn::vr::drawing
