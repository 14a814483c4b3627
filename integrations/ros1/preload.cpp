// libcatan_ros1_preload.so: functions of roscpp and nodeletlib by their own names, found before theirs (hooks.h).
//
// Names are looked up when they are first used, so that programs without these can have this loaded, too. It needs the
// libraries of C and C++ alone. Where it was compiled without nodeletlib's headers, that one's functions are its own.
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include "common/binding.h"
#include "common/middleware_threads.h"
#include "common/new_threads.h"
#include "common/observation.h"
#include "ros1/hooks.h"

#ifdef CATAN_NODELETLIB_LIBRARY
#include <nodelet/detail/callback_queue.h>
#include <nodelet/detail/callback_queue_manager.h>
#include <nodelet/nodelet.h>
#endif

namespace {

using catan_ros::Hooks;

std::atomic<const Hooks*> g_hooks{nullptr};

// The function of that name which would have been called without this library. `owner` is whose it is.
void* next_function(const char* name, const char* owner = CATAN_ROSCPP_LIBRARY) {
  void* found = ::dlsym(RTLD_NEXT, name);
  if (found == nullptr) {
    // Loaded by a plugin, for itself.
    void* const library = ::dlopen(owner, RTLD_LAZY | RTLD_NOLOAD);
    if (library != nullptr) found = ::dlsym(library, name);
  }
  if (found == nullptr) {
    std::fprintf(stderr, "catan: %s has no function %s; start the program without catan ros run\n", owner, name);
    std::abort();
  }
  return found;
}

// As the Itanium ABI has it, for functions that are not virtual.
template <class Member>
Member next_member(const char* name, const char* owner = CATAN_ROSCPP_LIBRARY) {
  struct Representation {
    void* function;
    std::ptrdiff_t adjustment;
  };
  static_assert(sizeof(Member) == sizeof(Representation));
  const Representation representation{next_function(name, owner), 0};
  Member member;
  std::memcpy(&member, &representation, sizeof member);
  return member;
}

// Beside this library.
const Hooks* load() {
  if (std::getenv(catan_ros::kBindingsVariable) == nullptr && std::getenv(catan_ros::kObserveVariable) == nullptr) {
    return nullptr;
  }
  Dl_info own{};
  if (::dladdr(reinterpret_cast<void*>(&next_function), &own) == 0) return nullptr;
  char path[4096];
  const char* const slash = std::strrchr(own.dli_fname, '/');
  const int folder = slash != nullptr ? static_cast<int>(slash + 1 - own.dli_fname) : 0;
  const int length = std::snprintf(path, sizeof path, "%.*slibcatan_ros1.so", folder, own.dli_fname);
  if (length < 0 || length >= static_cast<int>(sizeof path)) return nullptr;
  void* const library = ::dlopen(path, RTLD_NOW | RTLD_LOCAL);
  void* const symbol = library != nullptr ? ::dlsym(library, "catan_ros1_hooks") : nullptr;
  if (symbol == nullptr) {
    std::fprintf(stderr, "catan: %s; this program is not scheduled\n", ::dlerror());
    return nullptr;
  }
  const Hooks* const hooks = reinterpret_cast<const Hooks* (*)()>(symbol)();
  g_hooks.store(hooks, std::memory_order_release);
  if (hooks != nullptr) catan_ros::set_share_thread(hooks->share);
  return hooks;
}

const Hooks* hooks() {
  static const Hooks* const kLoaded = load();
  return kLoaded;
}

// Whether threads may be roscpp's; shells and such have none. Only that it is there is kept: a plugin may load it
// later. To go through what is loaded (dl_iterate_phdr) would be quicker, but a process that was forked while another
// thread did so can do it no more.
bool has_roscpp() {
  static std::atomic<bool> known{false};
  if (known.load(std::memory_order_relaxed)) return true;
  void* const library = ::dlopen(CATAN_ROSCPP_LIBRARY, RTLD_LAZY | RTLD_NOLOAD);
  if (library == nullptr) return false;
  ::dlclose(library);
  known.store(true, std::memory_order_relaxed);
  return true;
}

// Those that matter to the queues; null: no queue has bound callbacks.
const Hooks* hooks_of_queues() {
  const Hooks* const loaded = g_hooks.load(std::memory_order_acquire);
  return loaded != nullptr && loaded->has_turns->load(std::memory_order_acquire) ? loaded : nullptr;
}

// Whether that is code of roscpp's, as of ros::spin() and the threads of spinners. A thread asks for the same place
// again and again.
bool is_of_roscpp(const void* code) {
  thread_local const void* t_asked = nullptr;
  thread_local bool t_answer = false;
  if (std::exchange(t_asked, code) == code) return t_answer;
  Dl_info found{};
  t_answer = ::dladdr(code, &found) != 0 && found.dli_fname != nullptr &&
             std::strstr(found.dli_fname, "/libroscpp.so") != nullptr;
  return t_answer;
}

// From the call of a function that spins a queue to its return; `caller` is where it was called. A loop of the
// program's own that waits is told from roscpp's, which do nothing but spin.
class Spinning {
 public:
  Spinning(const ros::CallbackQueue* queue, ros::WallDuration timeout, const void* caller) : queue_(queue) {
    const Hooks* const known = hooks_of_queues();
    const bool waits = timeout.sec != 0 || timeout.nsec != 0;
    if (known != nullptr) in_loop_ = known->enter(queue_, waits && !is_of_roscpp(caller));
  }
  ~Spinning() {
    if (const Hooks* const known = hooks_of_queues()) known->leave(queue_, in_loop_);
  }
  Spinning(const Spinning&) = delete;
  Spinning& operator=(const Spinning&) = delete;

 private:
  const ros::CallbackQueue* queue_;
  bool in_loop_ = false;
};

// From the call of a callback in a queue to its return.
class Calling {
 public:
  explicit Calling(const ros::CallbackQueue* queue) {
    if (const Hooks* const known = hooks_of_queues()) begun_ = known->begin(queue);
  }
  ~Calling() {
    if (begun_ != nullptr) hooks_of_queues()->end(begun_);
  }
  Calling(const Calling&) = delete;
  Calling& operator=(const Calling&) = delete;

 private:
  void* begun_ = nullptr;
};

#ifdef CATAN_NODELETLIB_LIBRARY
// From the call of a nodelet's callback by its manager to its return. Its turn is taken before nodeletlib and roscpp
// take locks of their own: a bound callback that removes the other's subscription would wait for these.
class CallingNodelet {
 public:
  explicit CallingNodelet(const ros::CallbackQueueInterface* queue) : known_(g_hooks.load(std::memory_order_acquire)) {
    if (known_ != nullptr) taken_ = known_->call_nodelet(queue);
  }
  ~CallingNodelet() {
    if (taken_ != nullptr) known_->called_nodelet(taken_);
  }
  CallingNodelet(const CallingNodelet&) = delete;
  CallingNodelet& operator=(const CallingNodelet&) = delete;

 private:
  const Hooks* const known_;
  void* taken_ = nullptr;
};

template <class Member>
Member next_of_nodeletlib(const char* name) {
  return next_member<Member>(name, CATAN_NODELETLIB_LIBRARY);
}
#endif

}  // namespace

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*),
                              void* argument) noexcept {
  static const auto kNext = reinterpret_cast<catan_ros::CreateThread>(next_function("pthread_create"));
  const Hooks* const known = g_hooks.load(std::memory_order_acquire);
  const char* const node = known != nullptr ? known->current_node() : nullptr;
  const auto adopt = known != nullptr ? known->adopt : nullptr;
  const bool may_be_roscpps = catan_ros::may_make_middleware_thread(__builtin_return_address(0)) && has_roscpp();
  return catan_ros::create_thread(kNext, thread, attributes, {function, argument, adopt, node}, may_be_roscpps);
}

namespace ros {

Subscriber NodeHandle::subscribe(SubscribeOptions& ops) {
  static const auto kNext = next_member<catan_ros::Subscribe>("_ZN3ros10NodeHandle9subscribeERNS_16SubscribeOptionsE");
  if (const Hooks* const known = hooks()) return known->subscribe(*this, ops, kNext);
  return (this->*kNext)(ops);
}

ServiceServer NodeHandle::advertiseService(AdvertiseServiceOptions& ops) {
  static const auto kNext =
      next_member<catan_ros::AdvertiseService>("_ZN3ros10NodeHandle16advertiseServiceERNS_23AdvertiseServiceOptionsE");
  if (const Hooks* const known = hooks()) return known->advertise_service(*this, ops, kNext);
  return (this->*kNext)(ops);
}

Timer NodeHandle::createTimer(TimerOptions& ops) const {
  static const auto kNext =
      next_member<catan_ros::CreateTimer>("_ZNK3ros10NodeHandle11createTimerERNS_12TimerOptionsE");
  if (const Hooks* const known = hooks()) return known->create_timer(*this, ops, kNext);
  return (this->*kNext)(ops);
}

WallTimer NodeHandle::createWallTimer(WallTimerOptions& ops) const {
  static const auto kNext =
      next_member<catan_ros::CreateWallTimer>("_ZNK3ros10NodeHandle15createWallTimerERNS_16WallTimerOptionsE");
  if (const Hooks* const known = hooks()) return known->create_wall_timer(*this, ops, kNext);
  return (this->*kNext)(ops);
}

SteadyTimer NodeHandle::createSteadyTimer(SteadyTimerOptions& ops) const {
  static const auto kNext =
      next_member<catan_ros::CreateSteadyTimer>("_ZNK3ros10NodeHandle17createSteadyTimerERNS_18SteadyTimerOptionsE");
  if (const Hooks* const known = hooks()) return known->create_steady_timer(*this, ops, kNext);
  return (this->*kNext)(ops);
}

void Publisher::publish(const boost::function<SerializedMessage(void)>& serfunc, SerializedMessage& m) const {
  static const auto kNext =
      next_member<catan_ros::Publish>("_ZNK3ros9Publisher7publishERKN5boost8functionIFNS_17SerializedMessageEvEEERS3_");
  if (const Hooks* const known = g_hooks.load(std::memory_order_acquire))
    return known->publish(*this, serfunc, m, kNext);
  (this->*kNext)(serfunc, m);
}

void CallbackQueue::callAvailable(WallDuration timeout) {
  using CallAvailable = void (CallbackQueue::*)(WallDuration);
  static const auto kNext = next_member<CallAvailable>("_ZN3ros13CallbackQueue13callAvailableENS_12WallDurationE");
  const Spinning spinning(this, timeout, __builtin_return_address(0));
  (this->*kNext)(timeout);
}

CallbackQueue::CallOneResult CallbackQueue::callOne(WallDuration timeout) {
  using CallOne = CallOneResult (CallbackQueue::*)(WallDuration);
  static const auto kNext = next_member<CallOne>("_ZN3ros13CallbackQueue7callOneENS_12WallDurationE");
  const Spinning spinning(this, timeout, __builtin_return_address(0));
  return (this->*kNext)(timeout);
}

CallbackQueue::CallOneResult CallbackQueue::callOneCB(TLS* tls) {
  using CallOneCallback = CallOneResult (CallbackQueue::*)(TLS*);
  static const auto kNext = next_member<CallOneCallback>("_ZN3ros13CallbackQueue9callOneCBEPNS0_3TLSE");
  const Calling calling(this);
  return (this->*kNext)(tls);
}

void shutdown() {
  static const auto kNext = reinterpret_cast<void (*)()>(next_function("_ZN3ros8shutdownEv"));
  if (const Hooks* const known = g_hooks.load(std::memory_order_acquire)) known->shut_down();
  kNext();
}

}  // namespace ros

#ifdef CATAN_NODELETLIB_LIBRARY
namespace nodelet {

// Whose callbacks it is to make is known before it makes any.
void Nodelet::init(const std::string& name, const M_string& remapping_args, const V_string& my_argv,
                   ros::CallbackQueueInterface* st_queue, ros::CallbackQueueInterface* mt_queue) {
  using Init = void (Nodelet::*)(const std::string&, const M_string&, const V_string&, ros::CallbackQueueInterface*,
                                 ros::CallbackQueueInterface*);
  static const auto kNext = next_of_nodeletlib<Init>(
      "_ZN7nodelet7Nodelet4initERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEERKSt3mapIS6_S6_St4lessIS6_ESaISt4"
      "pairIS7_S6_EEERKSt6vectorIS6_SaIS6_EEPN3ros22CallbackQueueInterfaceESP_");
  if (const Hooks* const known = hooks()) {
    known->set_nodelet(st_queue, name);
    known->set_nodelet(mt_queue, name);
  }
  (this->*kNext)(name, remapping_args, my_argv, st_queue, mt_queue);
}

namespace detail {

void CallbackQueueManager::addQueue(const CallbackQueuePtr& queue, bool threaded) {
  using AddQueue = void (CallbackQueueManager::*)(const CallbackQueuePtr&, bool);
  static const auto kNext = next_of_nodeletlib<AddQueue>(
      "_ZN7nodelet6detail20CallbackQueueManager8addQueueERKN5boost10shared_ptrINS0_13CallbackQueueEEEb");
  if (const Hooks* const known = hooks()) known->add_nodelet_queue(queue.get(), !threaded);
  (this->*kNext)(queue, threaded);
}

void CallbackQueueManager::removeQueue(const CallbackQueuePtr& queue) {
  using RemoveQueue = void (CallbackQueueManager::*)(const CallbackQueuePtr&);
  static const auto kNext = next_of_nodeletlib<RemoveQueue>(
      "_ZN7nodelet6detail20CallbackQueueManager11removeQueueERKN5boost10shared_ptrINS0_13CallbackQueueEEE");
  if (const Hooks* const known = g_hooks.load(std::memory_order_acquire)) known->remove_nodelet_queue(queue.get());
  (this->*kNext)(queue);
}

uint32_t CallbackQueue::callOne() {
  using CallOne = uint32_t (CallbackQueue::*)();
  static const auto kNext = next_of_nodeletlib<CallOne>("_ZN7nodelet6detail13CallbackQueue7callOneEv");
  const CallingNodelet calling(this);
  return (this->*kNext)();
}

}  // namespace detail
}  // namespace nodelet
#endif
