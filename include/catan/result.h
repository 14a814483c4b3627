// Errors as values, for every call of Catan that can fail.
//
// A `Result<T>` holds either a T or an `Error`. An error lists everything that was found wrong, each entry a `Problem`:
// where it is, what is wrong there, and what to do about it. There are two kinds, because their readers differ:
//   kCaller       the caller's mistake (a misspelt key, a negative weight); the command exits with 2.
//   kEnvironment  the machine said no (a missing permission, a full disk); the command exits with 1.
// A bug in Catan itself is neither: it is an assertion.
//
// Thread safety: plain values, as safe as a std::string.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace ctn {

// A position in a text. `line` and `column` count from 1; 0 means "not known".
struct Place {
  std::string file;
  int line = 0;
  int column = 0;

  friend bool operator==(const Place&, const Place&) = default;
};

// One thing that is wrong: where, under which key, what, and how to fix it.
struct Problem {
  Place place;
  std::string key;   // dotted path, as in "nodes.GL.max_rate"; empty where there is none
  std::string what;  // what is wrong
  std::string hint;  // what to do; empty only where nothing sensible can be said
};

// "app.yaml:12:5: nodes.GL.max_rate: '50' has no unit; write 50Hz". Parts that are not known are left out.
std::string to_string(const Problem& problem);

enum class ErrorKind { kCaller, kEnvironment };

class [[nodiscard]] Error {
 public:
  Error(ErrorKind kind, std::vector<Problem> problems) : kind_(kind), problems_(std::move(problems)) {
    assert(!problems_.empty());
  }

  // The common case: one problem without a place in a text.
  static Error caller(std::string what, std::string hint) {
    return {ErrorKind::kCaller, {Problem{{}, {}, std::move(what), std::move(hint)}}};
  }
  static Error environment(std::string what, std::string hint) {
    return {ErrorKind::kEnvironment, {Problem{{}, {}, std::move(what), std::move(hint)}}};
  }

  ErrorKind kind() const { return kind_; }
  const std::vector<Problem>& problems() const { return problems_; }

  // All problems, one a line, without a trailing newline.
  std::string message() const;

 private:
  ErrorKind kind_;
  std::vector<Problem> problems_;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  // Precondition: ok().
  T& value() & { return *get(); }
  const T& value() const& { return *get(); }
  // By value, so that `for (auto& x : *f())` does not walk through a temporary that is gone.
  T value() && { return std::move(*get()); }
  T& operator*() & { return *get(); }
  const T& operator*() const& { return *get(); }
  T operator*() && { return std::move(*get()); }
  T* operator->() { return get(); }
  const T* operator->() const { return get(); }

  // Precondition: !ok().
  const Error& error() const {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }

 private:
  T* get() {
    assert(ok());
    return std::get_if<0>(&state_);
  }
  const T* get() const {
    assert(ok());
    return std::get_if<0>(&state_);
  }

  std::variant<T, Error> state_;
};

// For calls that return nothing but can fail: `return Done{};`
struct Done {};
using Status = Result<Done>;

}  // namespace ctn
