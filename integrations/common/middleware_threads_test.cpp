#include "common/middleware_threads.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <mutex>
#include <set>

#include "common/new_threads.h"

namespace catan_ros {
namespace {

TEST(MiddlewareThreads, AreThoseThatAMiddlewareMakesForItself) {
  EXPECT_EQ(maker_of({"libroscpp.so.4d", "_ZN3ros11PollManager5startEv"}), Maker::kMiddleware);
  EXPECT_EQ(maker_of({"libroscpp.so.4d", ""}), Maker::kMiddleware);
  EXPECT_EQ(maker_of({"libddsc.so.0", "ddsrt_thread_create"}), Maker::kMiddleware);
  EXPECT_EQ(maker_of({"librmw_cyclonedds_cpp.so", ""}), Maker::kMiddleware);
  EXPECT_EQ(maker_of({"libfastrtps.so.2.6", ""}), Maker::kMiddleware);
  EXPECT_EQ(maker_of({"libroscpp.so.4d", "_ZN3ros16AsyncSpinnerImpl5startEv"}), Maker::kOther)
      << "it calls the program's callbacks";
  EXPECT_EQ(maker_of({"libnodeletlib.so.1d", "_ZN7nodelet6detail20CallbackQueueManagerC1Ej"}), Maker::kOther)
      << "so do the threads of a nodelet manager";
  EXPECT_EQ(maker_of({"my_robot", "main"}), Maker::kOther);
  EXPECT_EQ(maker_of({"", ""}), Maker::kOther);
}

TEST(MiddlewareThreads, WhoCallsALibraryForThreadsCounts) {
  EXPECT_EQ(maker_of({"libboost_thread.so.1.74.0", "_ZN5boost6thread21start_thread_noexceptEv"}),
            Maker::kThreadLibrary);
  EXPECT_EQ(maker_of({"libstdc++.so.6", ""}), Maker::kThreadLibrary);
  EXPECT_EQ(maker_of({"libc.so.6", "pthread_create"}), Maker::kThreadLibrary);
}

TEST(MiddlewareThreads, ThatOfAProgramIsNone) { EXPECT_FALSE(makes_middleware_thread()); }

TEST(MiddlewareThreads, MostAreToldByThePlaceThatMakesThem) {
  EXPECT_FALSE(may_make_middleware_thread(reinterpret_cast<const void*>(&maker_of))) << "the program's";
  EXPECT_FALSE(may_make_middleware_thread(nullptr));
  const void* const of_c = ::dlsym(RTLD_DEFAULT, "gnu_get_libc_version");
  ASSERT_NE(of_c, nullptr);
  EXPECT_TRUE(may_make_middleware_thread(of_c)) << "who calls that?";
}

std::mutex g_mutex;
std::set<pid_t> g_told;
void note_told(pid_t thread) {
  const std::lock_guard lock(g_mutex);
  g_told.insert(thread);
}

int create_noted(pthread_t* thread, void* (*function)(void*), void* argument) {
  return create_hooked_thread(::pthread_create, thread, nullptr, {function, argument, note_middleware_thread, nullptr});
}

pid_t make_and_join() {
  pid_t number = 0;
  pthread_t thread{};
  const auto function = [](void* of) -> void* {
    *static_cast<pid_t*>(of) = ::gettid();
    return nullptr;
  };
  EXPECT_EQ(create_noted(&thread, function, &number), 0);
  EXPECT_EQ(::pthread_join(thread, nullptr), 0);
  return number;
}

bool is_told(pid_t thread) {
  const std::lock_guard lock(g_mutex);
  return g_told.contains(thread);
}

TEST(MiddlewareThreads, AreToldWheneverTheyBegan) {
  set_share_thread(nullptr);
  g_told.clear();
  std::promise<pid_t> begun;
  std::promise<void> end;
  struct Both {
    std::promise<pid_t>& begun;
    std::promise<void>& end;
  } both{begun, end};
  pthread_t thread{};
  const auto function = [](void* of) -> void* {
    static_cast<Both*>(of)->begun.set_value(::gettid());
    static_cast<Both*>(of)->end.get_future().wait();
    return nullptr;
  };
  ASSERT_EQ(create_noted(&thread, function, &both), 0);
  const pid_t before = begun.get_future().get();
  EXPECT_FALSE(is_told(before));
  set_share_thread(note_told);
  EXPECT_TRUE(is_told(before));
  const pid_t after = make_and_join();
  EXPECT_TRUE(is_told(after));
  set_share_thread(nullptr);
  EXPECT_FALSE(is_told(make_and_join()));
  end.set_value();
  EXPECT_EQ(::pthread_join(thread, nullptr), 0);
}

// Another may have got their numbers.
TEST(MiddlewareThreads, ThatHaveEndedAreNotTold) {
  set_share_thread(nullptr);
  g_told.clear();
  const pid_t returned = make_and_join();
  pthread_t thread{};
  pid_t left = 0;
  const auto leave = [](void* of) -> void* {
    *static_cast<pid_t*>(of) = ::gettid();
    ::pthread_exit(nullptr);
  };
  ASSERT_EQ(create_noted(&thread, leave, &left), 0);
  ASSERT_EQ(::pthread_join(thread, nullptr), 0);
  set_share_thread(note_told);
  set_share_thread(nullptr);
  EXPECT_FALSE(is_told(returned));
  EXPECT_FALSE(is_told(left));
}

}  // namespace
}  // namespace catan_ros
