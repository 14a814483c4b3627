#include "os/linux/shared_memory.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

namespace ctn::os {
namespace {

constexpr std::size_t kSize = 3 * 4096 + 100;

Descriptor duplicate(const Descriptor& descriptor) {
  return Descriptor(::fcntl(descriptor.number(), F_DUPFD_CLOEXEC, 0));
}

Descriptor plain_memory(off_t size, int seals) {
  Descriptor file(::memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_EQ(::ftruncate(file.number(), size), 0);
  EXPECT_EQ(::fcntl(file.number(), F_ADD_SEALS, seals), 0);
  return file;
}

std::string why(Descriptor descriptor, std::size_t min_size = 1) {
  const auto opened = SharedMemory::open(std::move(descriptor), min_size);
  if (opened.ok()) return "";
  EXPECT_EQ(opened.error().kind(), ErrorKind::kEnvironment);
  EXPECT_FALSE(opened.error().problems().front().hint.empty());
  return opened.error().message();
}

TEST(SharedMemory, IsZeroAtFirstAndSeenByAll) {
  const auto made = SharedMemory::create("catan-test", kSize);
  ASSERT_TRUE(made.ok()) << made.error().message();
  EXPECT_EQ(made->bytes().size(), kSize);
  EXPECT_TRUE(std::all_of(made->bytes().begin(), made->bytes().end(), [](std::byte b) { return b == std::byte{0}; }));
  const auto opened = SharedMemory::open(duplicate(made->descriptor()), kSize);
  ASSERT_TRUE(opened.ok()) << opened.error().message();
  EXPECT_NE(opened->bytes().data(), made->bytes().data());
  ASSERT_EQ(opened->bytes().size(), kSize);
  opened->bytes().back() = std::byte{42};
  EXPECT_EQ(made->bytes().back(), std::byte{42});
}

TEST(SharedMemory, IsSeenByAnotherProcess) {
  const auto made = SharedMemory::create("catan-test", kSize);
  ASSERT_TRUE(made.ok());
  const pid_t child = ::fork();
  if (child == 0) {
    made->bytes().front() = std::byte{7};
    ::_exit(0);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_EQ(made->bytes().front(), std::byte{7});
}

TEST(SharedMemory, NobodyCanChangeItsSizeOrItsSeals) {
  const auto made = SharedMemory::create("catan-test", kSize);
  ASSERT_TRUE(made.ok());
  const int file = made->descriptor().number();
  EXPECT_EQ(::ftruncate(file, 0), -1);
  EXPECT_EQ(errno, EPERM);
  EXPECT_EQ(::ftruncate(file, 1 << 20), -1);
  EXPECT_EQ(::fcntl(file, F_ADD_SEALS, F_SEAL_FUTURE_WRITE), -1);  // it would lock later clients out
  EXPECT_NE(::fcntl(file, F_GETFD) & FD_CLOEXEC, 0);
}

TEST(SharedMemory, StaysWhereItIsWhenMoved) {
  auto made = SharedMemory::create("catan-test", kSize);
  ASSERT_TRUE(made.ok());
  const std::byte* const at = made->bytes().data();
  SharedMemory moved = std::move(*made);
  EXPECT_EQ(moved.bytes().data(), at);
  EXPECT_TRUE(made->bytes().empty());
  moved = *SharedMemory::create("catan-test", 1);
  EXPECT_EQ(moved.bytes().size(), 1U);
}

TEST(SharedMemory, WhatCannotBeMadeIsRefused) {
  EXPECT_EQ(SharedMemory::create("catan-test", 0).error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(SharedMemory::create("catan-test", SIZE_MAX).error().kind(), ErrorKind::kCaller);
  EXPECT_EQ(SharedMemory::create(std::string(250, 'n'), 1).error().kind(), ErrorKind::kCaller);
  const auto huge = SharedMemory::create("catan-test", std::size_t{1} << 60);
  ASSERT_FALSE(huge.ok());
  EXPECT_EQ(huge.error().kind(), ErrorKind::kEnvironment);
  EXPECT_THAT(huge.error().message(), testing::HasSubstr("more than half of the memory that is free"));
}

TEST(SharedMemory, WhatCouldVanishInUseIsNotOpened) {
  constexpr int kSize4k = 4096;
  EXPECT_THAT(why(Descriptor()), testing::HasSubstr("no descriptor"));
  EXPECT_THAT(why(Descriptor(::open("/dev/null", O_RDWR | O_CLOEXEC))), testing::HasSubstr("another kind of file"));
  EXPECT_THAT(why(plain_memory(kSize4k, 0)), testing::HasSubstr("not sealed"));
  EXPECT_THAT(why(plain_memory(kSize4k, F_SEAL_GROW | F_SEAL_SEAL)), testing::HasSubstr("not sealed"));
  EXPECT_THAT(why(plain_memory(0, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL)), testing::HasSubstr("0 bytes"));
  EXPECT_THAT(why(plain_memory(kSize4k, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL), 4097),
              testing::HasSubstr("4096 bytes and needs 4097"));
  EXPECT_THAT(why(plain_memory(kSize4k, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL | F_SEAL_WRITE)),
              testing::HasSubstr("cannot map"));
  EXPECT_EQ(why(plain_memory(kSize4k, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL), 4096), "");
}

}  // namespace
}  // namespace ctn::os
