// A value that several threads use, together with the lock that guards it: a caller that wants the value takes the
// lock, and cannot forget to.
//
//   Guarded<std::vector<int>> numbers;
//   numbers.lock()->push_back(1);                      // for one expression
//   const auto held = numbers.lock(); held->clear();   // for a scope
//
// Thread safety: lock() from any thread; what it returns is one thread's.
#pragma once

#include <mutex>
#include <utility>

namespace ctn {

template <class T>
class Guarded {
 public:
  // Constructs the value from `arguments`.
  template <class... Arguments>
  explicit Guarded(Arguments&&... arguments) : value_(std::forward<Arguments>(arguments)...) {}
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;

  template <class Value>
  class Held {
   public:
    Held(std::mutex& mutex, Value& value) : lock_(mutex), value_(value) {}
    Value* operator->() const { return &value_; }
    Value& operator*() const { return value_; }

   private:
    std::unique_lock<std::mutex> lock_;
    Value& value_;
  };

  Held<T> lock() { return {mutex_, value_}; }
  Held<const T> lock() const { return {mutex_, value_}; }

 private:
  mutable std::mutex mutex_;
  T value_;
};

}  // namespace ctn
