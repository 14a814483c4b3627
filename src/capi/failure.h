// How calls of the C ABI (include/catan/catan.h) fail: what a call throws or returns as an error becomes a catan_error.
// src/capi is nothing but this and one function a call: it adds no behaviour to Session and Client.
//
// Thread safety: pure functions.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "base/result.h"
#include "catan/catan.h"

struct catan_error {
  catan_status status;
  std::string message;
};

namespace ctn::capi {

// Stores an error in `*out`, if there is an `out`. Returns `status`.
catan_status fail(catan_error** out, catan_status status, const char* message) noexcept;
catan_status fail(catan_error** out, const Error& error) noexcept;
// For a required argument that is NULL.
Error missing(const char* argument);

// body() returns a Status; whatever it throws is an error as well.
template <class Body>
catan_status guarded(catan_error** out, Body&& body) noexcept {
  try {
    const Status done = std::forward<Body>(body)();
    return done ? CATAN_OK : fail(out, done.error());
  } catch (const std::bad_alloc&) {
    return fail(out, CATAN_ENVIRONMENT, "there is no memory left");
  } catch (const std::exception& exception) {
    return fail(out, CATAN_BUG, exception.what());
  } catch (...) {
    return fail(out, CATAN_BUG, "an exception of an unknown kind");
  }
}

}  // namespace ctn::capi
