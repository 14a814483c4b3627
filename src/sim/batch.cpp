#include "sim/batch.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace ctn::sim {

void for_each_in_parallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  const auto labour = [&] {
    for (std::size_t index = next.fetch_add(1); index < count; index = next.fetch_add(1)) {
      try {
        work(index);
      } catch (...) {
        failures[index] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> helpers;
  for (std::size_t helper = 1; helper < std::min(threads, count); ++helper) helpers.emplace_back(labour);
  labour();
  for (std::thread& helper : helpers) helper.join();
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

void Progress::add() {
  if (!tell_ || untold_.fetch_add(1) > 0) return;
  std::size_t news = 1;
  do {
    told_ += news;
    tell_(told_);
    news = untold_.fetch_sub(news) - news;
  } while (news > 0);
}

}  // namespace ctn::sim
