// What of a Darknet network's description (FILE.cfg) OpenCV does not tell: how large its input is, and how many classes
// it knows. The rest of the file is OpenCV's business.
//
// The format: sections such as [net] or [yolo], in them lines KEY=VALUE; # begins a comment, ; too.
//
// Thread safety: values.
#pragma once

#include <string>

#include "catan/result.h"

namespace ctn::navigation {

struct DarknetFile {
  int width = 0;  // pixels, multiples of 32
  int height = 0;
  int classes = 0;
};

// `text` of the file `path`. Errors (kCaller): with the line and what to write there.
Result<DarknetFile> read_darknet(const std::string& text, const std::string& path);

}  // namespace ctn::navigation
