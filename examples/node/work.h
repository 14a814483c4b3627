// What is not Catan's: something to do, and waiting for Ctrl-C or SIGTERM.
#pragma once

#include <chrono>
#include <csignal>
#include <ctime>
#include <thread>

// Computes for two milliseconds, in the place of real work.
inline void work() {
  const std::clock_t end = std::clock() + CLOCKS_PER_SEC / 500;
  while (std::clock() < end) {
  }
}

inline volatile std::sig_atomic_t g_ended = 0;

inline void wait_for_the_end() {
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { g_ended = 1; });
  while (g_ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
}
