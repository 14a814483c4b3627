#include "common/middleware_threads.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace catan_ros {
namespace {

constexpr std::array<std::string_view, 5> kThreadLibraries{"libboost_thread", "libstdc++", "libc.so", "libc-",
                                                           "libpthread"};
constexpr std::array<std::string_view, 7> kMiddleware{"libroscpp", "libddsc",  "libfastrtps", "libfastdds",
                                                      "librmw_",   "libzenoh", "libiceoryx"};

template <std::size_t N>
bool begins_with_any(std::string_view name, const std::array<std::string_view, N>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](std::string_view beginning) { return name.starts_with(beginning); });
}

std::string_view without_folders(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string_view::npos ? path : path.substr(slash + 1);
}

Caller caller_of(const Dl_info& found) {
  return {without_folders(found.dli_fname), found.dli_sname != nullptr ? found.dli_sname : ""};
}

// Programs have few of them at a time. What does not fit is told only if there is a port when it begins.
constexpr std::size_t kMaxMiddlewareThreads = 256;
std::array<std::atomic<pid_t>, kMaxMiddlewareThreads> g_middleware_threads{};  // 0: none
std::atomic<ShareThread> g_share{nullptr};

// While the calling thread runs, also where it ends by pthread_exit(): another may get its number then.
class NotedThread {
 public:
  NotedThread() {
    const pid_t thread = ::gettid();
    for (std::atomic<pid_t>& each : g_middleware_threads) {
      pid_t none = 0;
      if (!each.compare_exchange_strong(none, thread)) continue;
      place_ = &each;
      break;
    }
    // Either this finds the function, or set_share_thread() finds the thread, or both: to be told twice does no harm.
    if (const ShareThread share = g_share.load()) share(thread);
  }
  ~NotedThread() {
    if (place_ != nullptr) place_->store(0);
  }
  NotedThread(const NotedThread&) = delete;
  NotedThread& operator=(const NotedThread&) = delete;

 private:
  std::atomic<pid_t>* place_ = nullptr;
};

}  // namespace

Maker maker_of(const Caller& caller) {
  if (begins_with_any(caller.library, kThreadLibraries)) return Maker::kThreadLibrary;
  if (!begins_with_any(caller.library, kMiddleware)) return Maker::kOther;
  return caller.function.find("Spinner") == std::string_view::npos ? Maker::kMiddleware : Maker::kOther;
}

bool makes_middleware_thread() {
  constexpr int kFrames = 24;
  std::array<void*, kFrames> frames{};
  const int count = ::backtrace(frames.data(), kFrames);
  Dl_info own{};
  if (::dladdr(reinterpret_cast<const void*>(&makes_middleware_thread), &own) == 0) return false;
  bool by_middleware = false;
  for (int frame = 0; frame < count; ++frame) {
    Dl_info of{};
    if (::dladdr(frames[static_cast<std::size_t>(frame)], &of) == 0 || of.dli_fname == nullptr) return by_middleware;
    if (of.dli_fbase == own.dli_fbase) continue;
    const Caller caller = caller_of(of);
    const Maker maker = maker_of(caller);
    // A spinner may make its threads by another function of its library.
    if (maker == Maker::kOther) return by_middleware && !begins_with_any(caller.library, kMiddleware);
    by_middleware = by_middleware || maker == Maker::kMiddleware;
  }
  return by_middleware;
}

bool may_make_middleware_thread(const void* caller) {
  Dl_info of{};
  return ::dladdr(caller, &of) != 0 && of.dli_fname != nullptr && maker_of(caller_of(of)) != Maker::kOther;
}

void set_share_thread(ShareThread share) {
  g_share.store(share);
  if (share == nullptr) return;
  for (const std::atomic<pid_t>& each : g_middleware_threads) {
    if (const pid_t thread = each.load(); thread != 0) share(thread);
  }
}

void note_middleware_thread(const char* /*node*/) { thread_local const NotedThread kNoted; }

}  // namespace catan_ros
