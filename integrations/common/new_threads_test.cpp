#include "common/new_threads.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>
#include <vector>

namespace catan_ros {
namespace {

std::vector<std::string> g_steps;  // of one thread at a time

void adopt(const char* node) { g_steps.emplace_back(node); }
void* work(void* argument) {
  g_steps.emplace_back("work");
  return argument;
}
int refuse(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) { return EAGAIN; }

// What the new thread did.
std::vector<std::string> steps_of_thread(const char* node) {
  g_steps.clear();
  pthread_t thread{};
  int argument = 0;
  EXPECT_EQ(create_thread(::pthread_create, &thread, nullptr, {work, &argument, adopt, node}, true), 0);
  void* result = nullptr;
  EXPECT_EQ(::pthread_join(thread, &result), 0);
  EXPECT_EQ(result, &argument);
  return g_steps;
}

TEST(NewThreads, OfANodesRunWorkForItBeforeAllElse) {
  EXPECT_EQ(steps_of_thread("detector"), (std::vector<std::string>{"detector", "work"}));
}

TEST(NewThreads, OfOthersAreAsTheyWouldBe) { EXPECT_EQ(steps_of_thread(nullptr), std::vector<std::string>{"work"}); }

TEST(NewThreads, ThatCannotBeMadeAreToldOf) {
  pthread_t thread{};
  EXPECT_EQ(create_thread(refuse, &thread, nullptr, {work, nullptr, adopt, "detector"}, false), EAGAIN);
  EXPECT_EQ(create_thread(refuse, &thread, nullptr, {work, nullptr, adopt, nullptr}, true), EAGAIN);
}

}  // namespace
}  // namespace catan_ros
