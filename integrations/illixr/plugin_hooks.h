// Put in front of the sources of ILLIXR's plugins by the compiler's option -include: makes their threadloops and their
// callbacks of the switchboard known to Catan. The sources stay as they are, and so does the runtime.
//
// It includes ILLIXR's own headers and gives three of their names another meaning in what comes after it:
//
//   plugin        one that tells Catan its name when it is made
//   threadloop    one that waits for Catan before each round: ILLIXR's calls catan_should_skip and catan_one_iteration
//                 in place of the two functions that plugins override, which are this class's own
//   switchboard   a handle of the runtime's, with the same functions: readers and writers tell Catan what goes through
//                 them, and callbacks that are nodes run when Catan says so
//
// Types that plugins share (events, services) keep their names. A plugin that was compiled without it works beside
// others; what it puts on topics reaches their callbacks by the runtime's own threads.
//
// Thread safety: as ILLIXR's own classes. C++17.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "illixr/service.h"

// Defined below.
#define DOUBLE_INCLUDE
#include "illixr/plugin.hpp"
#undef DOUBLE_INCLUDE

#include "illixr/cpu_timer.hpp"
#include "illixr/error_util.hpp"
#include "illixr/phonebook.hpp"
#include "illixr/record_logger.hpp"
#include "illixr/stoplight.hpp"
#include "illixr/switchboard.hpp"

// What the runtime asks of every plugin. One of several sources has it in each, and one of these is kept.
extern "C" __attribute__((weak, visibility("default"))) bool needs_monado() {
#ifdef MONADO_REQUIRED
  return true;
#else
  return false;
#endif
}

namespace ILLIXR {

// Null: Catan was not loaded, or not before.
inline catan_illixr::Service* find_catan(const phonebook& book) {
  return book.has_impl<catan_illixr::Service>() ? book.lookup_impl<catan_illixr::Service>().get() : nullptr;
}

class catan_plugin : public plugin {
 public:
  catan_plugin(std::string name, phonebook* book) : plugin{std::move(name), book} {
    if (catan_illixr::Service* const catan = find_catan(*book)) catan->note_plugin(id_, name_);
  }
};

}  // namespace ILLIXR

#define plugin catan_plugin
#define threadloop catan_plain_threadloop
#define _p_should_skip catan_should_skip
#define _p_one_iteration catan_one_iteration
#include "illixr/threadloop.hpp"
#undef threadloop
#undef _p_should_skip
#undef _p_one_iteration

namespace ILLIXR {

class catan_threadloop : public catan_plain_threadloop {
 public:
  using catan_plain_threadloop::catan_plain_threadloop;

 protected:
  virtual skip_option _p_should_skip() { return skip_option::run; }
  virtual void _p_one_iteration() = 0;

 private:
  skip_option catan_should_skip() final {
    if (!looked_) {
      looked_ = true;
      if (catan_illixr::Service* const catan = find_catan(*phonebook_)) node_ = catan->find_loop(id_);
    }
    if (node_ == nullptr) return _p_should_skip();
    if (!node_->wait()) return skip_option::stop;
    const skip_option option = _p_should_skip();
    if (option == skip_option::skip_and_yield || option == skip_option::skip_and_spin) node_->skip();
    return option;
  }
  void catan_one_iteration() final {
    if (node_ != nullptr) node_->begin();
    _p_one_iteration();
    if (node_ != nullptr) node_->end();
  }

  bool looked_ = false;
  catan_ros::LoopHook* node_ = nullptr;
};

// --- The switchboard ---

template <class Event>
const void* catan_address(const std::shared_ptr<Event>& event) {
  return static_cast<const switchboard::event*>(event.get());
}

template <class Event>
catan_illixr::Message catan_message(const std::shared_ptr<Event>& event) {
  return catan_illixr::Message{event, catan_address(event)};
}

// `topic` is null without Catan.
template <class Event>
class catan_reader : public switchboard::reader<Event> {
 public:
  catan_reader(const switchboard::reader<Event>& base, catan_ros::TopicHook* topic)
      : switchboard::reader<Event>{base}, catan_topic_{topic} {}

  std::shared_ptr<const Event> get_ro_nullable() const noexcept {
    return note(switchboard::reader<Event>::get_ro_nullable());
  }
  std::shared_ptr<const Event> get_ro() const { return note(switchboard::reader<Event>::get_ro()); }
  std::shared_ptr<Event> get_rw() const { return std::make_shared<Event>(*get_ro()); }

 private:
  std::shared_ptr<const Event> note(std::shared_ptr<const Event> event) const {
    if (catan_topic_ != nullptr && event != nullptr) catan_topic_->taken(catan_address(event));
    return event;
  }
  catan_ros::TopicHook* catan_topic_;
};

template <class Event>
class catan_buffered_reader : public switchboard::buffered_reader<Event> {
 public:
  catan_buffered_reader(const switchboard::buffered_reader<Event>& base, catan_ros::TopicHook* topic)
      : switchboard::buffered_reader<Event>{base}, catan_topic_{topic} {}

  std::shared_ptr<const Event> dequeue() override {
    std::shared_ptr<const Event> event = switchboard::buffered_reader<Event>::dequeue();
    if (catan_topic_ != nullptr && event != nullptr) catan_topic_->taken(catan_address(event));
    return event;
  }

 private:
  catan_ros::TopicHook* catan_topic_;
};

// `Base` is a writer, which asks to be the only one that holds what it is given.
template <class Event, class Base>
class catan_writer_of : public Base {
 public:
  catan_writer_of(const Base& base, catan_ros::TopicHook* topic) : Base{base}, catan_topic_{topic} {}

  void put(std::shared_ptr<Event>&& event) override {
    if (catan_topic_ == nullptr) return Base::put(std::move(event));
    const std::weak_ptr<Event> put = event;
    catan_topic_->publishing(catan_address(event));
    Base::put(std::move(event));
    catan_topic_->published(catan_message(put.lock()));
  }

 private:
  catan_ros::TopicHook* catan_topic_;
};

template <class Type, class...>
struct catan_given {
  using type = Type;
};

class catan_switchboard {
 public:
  template <class Event>
  using ptr = switchboard::ptr<Event>;
  using event = switchboard::event;
  template <class Underlying>
  using event_wrapper = switchboard::event_wrapper<Underlying>;
  template <class Event>
  using reader = catan_reader<Event>;
  template <class Event>
  using buffered_reader = catan_buffered_reader<Event>;
  template <class Event>
  using writer = catan_writer_of<Event, switchboard::writer<Event>>;
  template <class Event>
  using network_writer = catan_writer_of<Event, switchboard::network_writer<Event>>;

  explicit catan_switchboard(const phonebook& book)
      : runtimes_{book.lookup_impl<switchboard>()},
        catan_{find_catan(book)},
        root_coordinates{runtimes_->root_coordinates} {}

  template <class Event>
  void schedule(plugin_id_t plugin_id, const std::string& topic,
                std::function<void(ptr<const Event>&&, std::size_t)> fn) {
    catan_ros::CallbackHook* node = nullptr;
    if (catan_ != nullptr) {
      const auto call = [fn, count = std::size_t{0}](const catan_illixr::Message& message) mutable {
        fn(std::dynamic_pointer_cast<const Event>(std::static_pointer_cast<const event>(message)), ++count);
      };
      node = catan_->bind(plugin_id, topic, call);
    }
    if (node == nullptr) return runtimes_->schedule<Event>(plugin_id, topic, std::move(fn));
    runtimes_->schedule<Event>(
        plugin_id, topic, [node](ptr<const Event>&& arrived, std::size_t) { node->arrived(catan_message(arrived)); });
  }

  template <class Event>
  reader<Event> get_reader(const std::string& topic) {
    return {runtimes_->get_reader<Event>(topic), hook(topic)};
  }
  template <class Event>
  buffered_reader<Event> get_buffered_reader(const std::string& topic) {
    return {runtimes_->get_buffered_reader<Event>(topic), hook(topic)};
  }
  template <class Event>
  writer<Event> get_writer(const std::string& topic) {
    return {runtimes_->get_writer<Event>(topic), hook(topic)};
  }
  template <class Event, class... Config>
  network_writer<Event> get_network_writer(const std::string& topic, Config&&... config) {
    return {runtimes_->get_network_writer<Event>(topic, std::forward<Config>(config)...), hook(topic)};
  }

// Looked up when it is used: not all versions have all of them.
#define CATAN_AS_IT_IS(function)                                              \
  template <class... Arguments>                                               \
  decltype(auto) function(Arguments&&... arguments) {                         \
    typename catan_given<switchboard, Arguments...>::type& real = *runtimes_; \
    return real.function(std::forward<Arguments>(arguments)...);              \
  }
  CATAN_AS_IT_IS(topic_exists)
  CATAN_AS_IT_IS(get_topic)
  CATAN_AS_IT_IS(set_env)
  CATAN_AS_IT_IS(env_names)
  CATAN_AS_IT_IS(get_env)
  CATAN_AS_IT_IS(get_env_bool)
  CATAN_AS_IT_IS(get_env_char)
  CATAN_AS_IT_IS(get_env_int)
  CATAN_AS_IT_IS(get_env_long)
  CATAN_AS_IT_IS(get_env_ulong)
  CATAN_AS_IT_IS(get_env_double)
  CATAN_AS_IT_IS(stop)
#undef CATAN_AS_IT_IS

 private:
  catan_ros::TopicHook* hook(const std::string& topic) { return catan_ != nullptr ? &catan_->topic(topic) : nullptr; }

  const std::shared_ptr<switchboard> runtimes_;
  catan_illixr::Service* const catan_;

 public:
  decltype(std::declval<switchboard&>().root_coordinates)& root_coordinates;
};

template <>
inline std::shared_ptr<catan_switchboard> phonebook::lookup_impl<catan_switchboard>() const {
  return std::make_shared<catan_switchboard>(*this);
}

}  // namespace ILLIXR

#define threadloop catan_threadloop
#define switchboard catan_switchboard
