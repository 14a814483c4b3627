// Where the tests' own apps are.
#pragma once

#include <string>

namespace ctn::test {

inline const std::string kTestApps = std::string(CATAN_TESTS) + "/apps";

}  // namespace ctn::test
