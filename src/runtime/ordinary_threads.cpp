#include "runtime/ordinary_threads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/text.h"

namespace ctn::runtime {
namespace {

constexpr std::size_t kMaxNamedThreads = 5;

}  // namespace

OrdinaryThreads::News OrdinaryThreads::look(TimePoint now, const std::vector<Sample>& threads) {
  News news{now - std::exchange(looked_at_, now), {}};
  const std::map<os::ThreadId, Sample> before = std::exchange(before_, {});
  for (const Sample& sample : threads) {
    before_[sample.thread] = sample;
    const auto last = before.find(sample.thread);
    if (last == before.end()) continue;
    const Nanos ran = sample.cpu - last->second.cpu;
    const Nanos waited = std::min(sample.ready - last->second.ready, news.elapsed);
    if (ran < Nanos{0}) continue;  // another thread, which has its number
    if (waited > Nanos{0} && 2 * waited >= news.elapsed) news.threads.push_back({sample.thread, waited, ran});
  }
  if (told_ && news.threads.empty() && now - waited_at_ >= kQuiet) told_ = false;
  if (news.threads.empty()) return news;
  waited_at_ = now;
  if (std::exchange(told_, true)) news.threads.clear();
  std::stable_sort(news.threads.begin(), news.threads.end(),
                   [](const Waiting& one, const Waiting& two) { return one.waited > two.waited; });
  return news;
}

std::string notice_of(const std::string& program, const OrdinaryThreads::News& news,
                      const std::function<std::string(os::ThreadId)>& name_of) {
  std::string threads;
  for (std::size_t index = 0; index < std::min(news.threads.size(), kMaxNamedThreads); ++index) {
    const OrdinaryThreads::Waiting& one = news.threads[index];
    const std::string name = printable(name_of(one.thread));
    threads += fmt::format("{}{}(thread {}) waited for {:.1f} s and ran for {:.1f} s", index > 0 ? ", " : "",
                           name.empty() ? "" : name + " ", static_cast<std::int32_t>(one.thread),
                           in_seconds(one.waited), in_seconds(one.ran));
  }
  if (news.threads.size() > kMaxNamedThreads)
    threads += fmt::format(", and {} more", news.threads.size() - kMaxNamedThreads);
  return fmt::format(
      "threads of {} that no node has wait for a CPU most of the time: nodes go before them. Of the last "
      "{:.1f} s {}. Bind what they do to a node, give the nodes a max_rate, or leave a CPU free of nodes (--cpus)",
      program, in_seconds(news.elapsed), threads);
}

}  // namespace ctn::runtime
