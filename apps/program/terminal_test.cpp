#include "program/terminal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace ctn::program {
namespace {

// Guards: a notice of a session was an exception in the thread that delivers it, and ended the program.
TEST(Note, EndsNothingWhereItCannotBeWritten) {
  const int before = ::dup(STDERR_FILENO);
  const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  ASSERT_GE(full, 0);
  ASSERT_GE(::dup2(full, STDERR_FILENO), 0);
  EXPECT_NO_THROW(note("app", "something"));
  const int code = fail("app", Error::caller("something", "do it otherwise"));
  ASSERT_GE(::dup2(before, STDERR_FILENO), 0);
  ::close(before);
  ::close(full);
  EXPECT_EQ(code, kMistake);
}

}  // namespace
}  // namespace ctn::program
