// Text from anywhere (names in an app file, notes in a record) made safe to stand in HTML and XML.
#pragma once

#include <string>
#include <string_view>

namespace ctn::report {

// For element content and for attributes in either kind of quotes. Control characters and what is no UTF-8 become
// U+FFFD.
std::string escaped(std::string_view text);

// The same without marks escaped: valid UTF-8 on one line.
std::string cleaned(std::string_view text);

}  // namespace ctn::report
