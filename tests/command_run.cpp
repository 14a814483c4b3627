#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "command_test.h"

namespace ctn::test {

std::string read_all(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// Sanitizers make plans ten times as slow.
#ifdef CATAN_SANITIZED
constexpr const char* kLimit = "120";
#else
constexpr const char* kLimit = "20";
#endif

Outcome run_catan(const std::string& arguments, const std::string& folder) {
  // CTest runs each test as a process of its own, several at a time.
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string base = ::testing::TempDir() + "catan_" + test->test_suite_name() + "_" + test->name();
  for (char& c : base) c = c == '/' && &c > base.data() + ::testing::TempDir().size() ? '_' : c;
  const std::string command = "cd '" + folder + "' && timeout " + kLimit + " '" CATAN_COMMAND "' " + arguments +
                              " > '" + base + ".out' 2> '" + base + ".err' < /dev/null";
  const int status = std::system(command.c_str());
  Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_all(base + ".out"),
                  read_all(base + ".err")};
  std::remove((base + ".out").c_str());
  std::remove((base + ".err").c_str());
  return outcome;
}

}  // namespace ctn::test
