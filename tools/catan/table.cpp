#include "table.h"

#include <fmt/format.h>

namespace ctn::tool {

std::string ms_text(Millis duration) { return fmt::format("{:.3f}ms", duration.count()); }

}  // namespace ctn::tool
